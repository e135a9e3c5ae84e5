/* The summary of the run. */

const UNITS = {
  duration: "s", gantry_disabled_time: "s", started: "s", time_standing: "s", distance_walked: "m",
};

const TRIAL_FIELDS = ["trial", "floorplan", "rules", "seed", "duration", "interrupted"];

/** The summary of the run, as it stands in the recording: figures first, then people, then the trial. */
function showSummary(section, summary, onChoose) {
  const { minimum_separation: closest, people, ...rest } = summary ?? {};
  const figures = Object.entries(rest).filter(([name]) => !TRIAL_FIELDS.includes(name));
  const ofTrial = Object.entries(rest).filter(([name]) => TRIAL_FIELDS.includes(name));
  section.replaceChildren(fieldList([...figures, ["minimum separation", closest]], onChoose));
  for (const [name, fields] of Object.entries(people ?? {})) {
    section.append(element("h3", { text: spoken(name) }), fieldList(Object.entries(fields), onChoose));
  }
  if (ofTrial.length) section.append(element("h3", { text: "trial" }), fieldList(ofTrial, onChoose));
}

/** Names and values as a list; an object with a time and a distance becomes a button to go there. */
function fieldList(fields, onChoose) {
  const list = element("dl");
  const add = (name, content) => {
    list.append(element("dt", { text: spoken(name) }), element("dd", {}, content));
  };
  for (const [name, value] of fields) {
    if (value === null || value === undefined) continue;
    if (isObject(value) && isNumbers([value.time, value.distance])) {
      const text = `${metres(value.distance)} at ${seconds(value.time)}`;
      const button = element("button", { type: "button", text });
      button.addEventListener("click", () => onChoose(value.time));
      add(name, button);
    } else if (isObject(value)) {
      const inner = Object.entries(value).map(([key, one]) => [`${name} ${key}`, one]);
      list.append(...fieldList(inner, onChoose).children);
    } else {
      add(name, valueText(name, value));
    }
  }
  return list;
}

function valueText(name, value) {
  if (Array.isArray(value)) {
    return value.length ? `${value.length}: ${value.map(spoken).join(", ")}` : "none";
  }
  if (typeof value !== "number") return String(value);
  const figure = Number.isInteger(value) ? String(value) : fixed(value, 2);
  return UNITS[name] ? `${figure} ${UNITS[name]}` : figure;
}
