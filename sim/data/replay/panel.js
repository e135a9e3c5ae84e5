/* Elements, and the figures of the instant. */

const LETTERS = ["A", "B"];

const $ = id => document.getElementById(id);

function element(tag, { text, className, ...attributes } = {}, ...children) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  if (className) made.className = className;
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

/** A copy of the element in a <template>. */
function stamp(id) {
  return $(id).content.firstElementChild.cloneNode(true);
}

/** Writes into an element if the text has changed. */
function write(target, text) {
  if (target.textContent !== text) target.textContent = text;
}

const STATES = {
  clear: { shape: "disc", hollow: true, color: "muted", text: "enough distance" },
  noticed: { shape: "diamond", color: "notice", text: "within the noticing distance" },
  short: { shape: "triangle", hollow: true, color: "danger", text: "closer than required, and not counted" },
  violation: { shape: "triangle", color: "danger", text: "too close: violation" },
  apart: { shape: "disc", hollow: true, color: "muted", text: "apart" },
  absent: { shape: "disc", hollow: true, color: "muted", text: "not both on the floor" },
  touching: { shape: "triangle", hollow: true, color: "danger", text: "touching" },
};
const TOUCH = 0.005;         // metres between two people who seem to touch

function stateOf({ margin, distance, notice, violated }, { isOfPeople }) {
  if (Number.isNaN(margin)) return "absent";
  if (isOfPeople) return margin > TOUCH ? "apart" : "touching";
  if (violated) return "violation";
  if (margin < 0) return "short";
  return notice !== null && distance < notice ? "noticed" : "clear";
}

/**
 * Distance, required distance, margin, speeds and the job of one run at an instant;
 * with the names of the pair, if it is not the `chosen` one.
 */
class Readout {
  constructor(letter) {
    this.root = stamp("readout");
    this.root.dataset.letter = letter;
    this.places = Object.fromEntries(
      [...this.root.querySelectorAll("[data-shows]")].map(place => [place.dataset.shows, place]));
  }

  show(run, watch, chosen, t, afterglow) {
    const put = (name, text) => write(this.places[name], text);
    put("time", seconds(t));
    const hasJobs = run.jobs.changes.size > 0;
    this.places.job.parentElement.hidden = !hasJobs;
    if (hasJobs) {
      const machine = run.jobs.shown(watch?.other.name, t);
      const job = run.jobs.of(machine, t);
      put("job-of", `job of ${spoken(machine)}`);
      put("job", job ? `${jobWords(job)}, since ${seconds(job.t)}` : "none");
    }
    const pair = pairOf(watch, chosen);
    put("pair", pair);
    this.places.pair.hidden = pair === "";
    this.root.classList.toggle("unpaired", !watch && pair !== "");
    if (!watch) return;
    const now = watch.at(t);
    const { digits } = toldApart(now.distance, now.required);
    for (const name of ["distance", "required", "margin"]) {
      put(name, Number.isNaN(now[name]) ? "–" : `${fixed(now[name], digits)} m`);
    }
    put("person", spoken(watch.person.name));
    put("person-speed", `${fixed(now.personSpeed, 2)} m/s`);
    put("other", spoken(watch.other.name));
    put("other-speed", `${fixed(now.otherSpeed, 2)} m/s`);
    const lately = run.violationLately(watch, t, afterglow);
    const state = lately ? "violation" : stateOf(now, watch);
    put("state", lately
      ? `violation at ${seconds(lately.t)}, ${comparison(lately.distance ?? now.distance, lately.required)}`
      : STATES[state].text);
    for (const name of ["distance", "required", "margin"]) put(`${name}-word`, watch.words[name]);
    if (this.root.dataset.state === state) return;
    this.root.dataset.state = state;
    this.places.glyph.replaceChildren(glyphElement(STATES[state]));
  }
}

/** Lines of text beside the pointer. */
function showHint(event, ...lines) {
  const hint = $("hint");
  if (event.pointerType === "touch") return;
  hint.hidden = false;
  hint.textContent = lines.filter(Boolean).join("\n");
  const { width, height } = hint.getBoundingClientRect();
  const x = Math.min(event.clientX + 14, innerWidth - width - 6);
  const y = event.clientY + 16 + height > innerHeight ? event.clientY - height - 12 : event.clientY + 16;
  hint.style.transform = `translate(${x}px, ${y}px)`;
}

function hideHint() {
  $("hint").hidden = true;
}
