/* Numbers, list of events, summary. */

const $ = id => document.getElementById(id);

function element(tag, { text, html, className, ...attributes } = {}, ...children) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  if (html !== undefined) made.innerHTML = html;     // only ever our own shapes, never the recording's text
  if (className) made.className = className;
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

/** Writes into elements, and only what has changed. */
function write(id, text) {
  const target = $(id);
  if (target.textContent !== text) target.textContent = text;
}

const STATES = {
  clear: { shape: "disc", hollow: true, color: "muted", text: "enough distance" },
  noticed: { shape: "diamond", color: "notice", text: "within the noticing distance" },
  short: { shape: "triangle", hollow: true, color: "danger", text: "closer than required, and not counted" },
  violation: { shape: "triangle", color: "danger", text: "too close: violation" },
};

function stateOf({ margin, distance, notice, violated }) {
  if (violated) return "violation";
  if (margin < 0) return "short";
  return notice !== null && distance < notice ? "noticed" : "clear";
}

/** The numbers of one watch at `t`; `lately` is a violation of it that was just counted. */
function showNumbers(watch, t, lately) {
  write("clock-time", seconds(t));
  write("now-time", seconds(t));
  if (!watch) return;
  const now = watch.at(t);
  write("now-distance", metres(now.distance));
  write("now-required", metres(now.required));
  write("now-margin", metres(now.margin));
  write("now-person-speed", `${fixed(now.personSpeed, 2)} m/s`);
  write("now-other-speed", `${fixed(now.otherSpeed, 2)} m/s`);
  write("person-name", spoken(watch.person.name));
  write("other-name", spoken(watch.other.name));
  const state = lately ? "violation" : stateOf(now);
  write("state-words", lately
    ? `violation at ${seconds(lately.t)}: ${comparison(lately.distance ?? now.distance, lately.required)}`
    : STATES[state].text);
  if ($("state").dataset.state === state) return;
  $("state").dataset.state = state;
  $("state-glyph").innerHTML = glyph(STATES[state]);
}
