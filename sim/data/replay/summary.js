/* The summaries of the runs, beside each other. */

const UNITS = { duration: "s", started: "s", distance_walked: "m", throughput: "1/h" };
const IS_TIME = /^time_|_time$/;
const LABELS = { law_audit: "stopping underestimated for" };
const TRIAL_FIELDS = ["trial", "floorplan", "rules", "seed", "duration", "interrupted"];

/** Shows summaries as recorded: figures first, then people, then the trial. */
function showSummaries(section, summaries, onChoose) {
  const people = summaries.map(summary => summary.people ?? {});
  const names = [...new Set(people.flatMap(Object.keys))];
  const isOfTrial = name => TRIAL_FIELDS.includes(name);
  const part = (title, fields) => {
    const list = fieldList(fields, onChoose);
    return list.children.length ? [title && element("h3", { text: title }), list].filter(Boolean) : [];
  };
  const some = choose => summaries.map(summary => Object.fromEntries(
    Object.entries(summary).filter(([name]) => name !== "people" && choose(name))));
  section.replaceChildren(
    ...part("", some(name => !isOfTrial(name))),
    ...names.flatMap(name => part(spoken(name), people.map(fields => fields[name] ?? {}))),
    ...part("trial", some(isOfTrial)));
}

/** Each name with its value in every one of `columns`; values that differ stand out. */
function fieldList(columns, onChoose) {
  const list = element("dl", { style: `--columns: ${columns.length}` });
  const flat = columns.map(fields => new Map(Object.entries(fields).flatMap(flattened)));
  for (const name of new Set(flat.flatMap(fields => [...fields.keys()]))) {
    const values = flat.map(fields => fields.get(name));
    const differ = new Set(values.map(value => JSON.stringify(value))).size > 1;
    list.append(element("dt", { text: LABELS[name] ?? spoken(name) }), ...values.map(value => (
      element("dd", { className: differ ? "different" : "" }, content(name, value, onChoose)))));
  }
  return list;
}

/** [name, value] as a flat list of such: no empty values, no objects. */
function flattened([name, value]) {
  if (value === null || value === undefined) return [];
  if (!isObject(value) || isInstant(value)) return [[name, value]];
  return Object.entries(value).flatMap(([key, inner]) => flattened([`${name} ${key}`, inner]));
}

const isInstant = value => isObject(value) && isNumbers([value.time, value.distance]);

/** A value in words; a distance at an instant is a button to go there. */
function content(name, value, onChoose) {
  if (value === undefined) return "–";
  if (!isInstant(value)) return valueText(name, value);
  const between = value.between ?? [value.person, value.agv].filter(Boolean);
  const whose = between.length ? ` (${between.map(spoken).join(" and ")})` : "";
  const text = `${metres(value.distance)}${whose} at ${seconds(value.time)}`;
  const button = element("button", { type: "button", text });
  button.addEventListener("click", () => onChoose(value.time));
  return button;
}

function valueText(name, value) {
  if (Array.isArray(value)) return counted(value);
  if (typeof value !== "number") return String(value);
  const figure = Number.isInteger(value) ? String(value) : fixed(value, 2);
  const key = name.split(" ").at(-1);
  const unit = UNITS[key] ?? (IS_TIME.test(key) ? "s" : "");
  return unit ? `${figure} ${unit}` : figure;
}

/** A value of a list; an object by its fields, a finding about a machine by the machine's name. */
const inWords = value => (isObject(value)
  ? value.machine ?? Object.entries(value).map(([name, inner]) => `${spoken(name)} ${spoken(inner)}`).join(", ") : String(value));

/** The count of each value in a list, in order of first appearance. */
function counted(values) {
  const counts = new Map();
  for (const value of values.map(inWords)) counts.set(value, (counts.get(value) ?? 0) + 1);
  const times = values.some(isObject) ? () => "" : n => ` ${n}×`;
  return [...counts].map(([value, n]) => spoken(value) + times(n)).join(", ") || "none";
}
