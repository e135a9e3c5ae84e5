/* The mind of a person at an instant: intentions, the last steps, beliefs. */

const STEP_WORDS = { percept: "perceives", plan: "plan", action: "does", warning: "warning" };

/** Shows the mind of one person; nothing is written while nothing changes. */
class MindPanel {
  constructor(root) {
    this.root = root;
    this.person = root.querySelector(".whose");
    this.intentions = root.querySelector(".intentions");
    this.steps = root.querySelector(".steps");
    this.beliefs = root.querySelector(".beliefs");
    this.shown = null;
  }

  show(run, person, t) {
    const mind = run.mindOf(person?.name);
    this.root.hidden = !mind;
    if (!mind) return;
    const state = mind.at(t);
    if (!state.intentions.length) this.#showIdle(run, person, t);
    if (this.shown === state) return;
    this.shown = state;
    write(this.person, `${spoken(person.name)}, ${run.personality(person, t)}`);
    if (state.intentions.length) this.intentions.replaceChildren(...state.intentions.map(intentionItem));
    this.steps.replaceChildren(...state.steps.map(step => stepItem(step, step.t === state.t)));
    const beliefs = [...state.beliefs].sort(([, a], [, b]) => b - a);
    const came = beliefs.filter(([text]) => mind.isChanging(text));
    const stayed = beliefs.filter(([text]) => !mind.isChanging(text));
    this.beliefs.replaceChildren(
      ...came.map(([text, since]) => beliefItem(text, since === state.t ? "new" : "")),
      ...stayed.map(([text]) => beliefItem(text, "lasting")));
  }

  /** No plan is at work: what the body does. */
  #showIdle(run, person, t) {
    const goal = run.goalOf(person, t);
    const isWalking = person.motion.at(t).speed > STILL;
    const words = isWalking ? `walks${goal ? ` to ${where(goal)}` : ""}; no plan is at work meanwhile`
      : "none: waits for something to happen";
    if (this.intentions.textContent !== words) {
      this.intentions.replaceChildren(element("li", { className: "none", text: words }));
    }
  }
}

function intentionItem({ stack, at }) {
  const trail = stack.map(trigger => element("code", { text: short(trigger), title: trigger }));
  const item = element("li", {}, ...trail);
  if (at) item.append(element("small", { text: `at ${short(at)}` }));
  return item;
}

function stepItem({ t, kind, text, place }, isLatest) {
  return element("li", { className: `${kind}${isLatest ? " new" : ""}` },
    element("time", { text: clockTime(t, 2) }), element("span", { text: STEP_WORDS[kind] ?? kind }),
    element("code", { text: short(text), title: [text, place].filter(Boolean).join("  ") }));
}

function beliefItem(text, className) {
  return element("li", { className }, element("code", { text: short(text), title: text }));
}

/** A literal with its long decimals shortened, and without the annotations of a plan that failed. */
const short = text => text.replace(/\[code\(.*\]$/s, "").replace(/-?\d+\.\d{3,}(?:E-?\d+)?/g, number => String(+Number(number).toFixed(2)));
