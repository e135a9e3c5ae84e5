/* What goes on in a person's mind, and what the gantry is at: from changes to what holds at t. */

const CHECKPOINT = 50;        // thoughts between two beliefs-as-a-whole that are kept
const RECENT_STEPS = 6;       // of percepts, plans and actions, the latest are told

/** One person's thoughts: what they believed, wanted, saw and did at any instant. */
class Mind {
  constructor(thoughts) {
    this.thoughts = thoughts;
    this.times = Float64Array.from(thoughts, thought => thought.t);
    this.changing = new Set();       // functors of beliefs that come and go
    this.checkpoints = [];           // what was believed before every so many thoughts
    this.intents = [];               // of each thought: the last one up to it that tells intentions
    const believed = new Map();
    let intent = [];
    thoughts.forEach((thought, i) => {
      if (i % CHECKPOINT === 0) this.checkpoints.push(new Map(believed));
      if (thought.t > thoughts[0].t) {
        for (const text of [...thought.believes ?? [], ...thought.forgets ?? []]) this.changing.add(functor(text));
      }
      apply(believed, thought);
      intent = thought.intends ?? intent;
      this.intents.push(intent);
    });
    this.latest = { index: undefined };
  }

  /** {index, t, beliefs: Map of text to since when, intentions, steps: [{t, kind, text, place}]}. */
  at(t) {
    const index = lastUpTo(this.times, t + 1e-9);
    if (this.latest.index !== index) this.latest = this.#after(index);
    return this.latest;
  }

  /** Whether a belief is one of those that come and go. */
  isChanging(text) {
    return this.changing.has(functor(text));
  }

  #after(index) {
    if (index < 0) return { index, t: null, beliefs: new Map(), intentions: [], steps: [] };
    const checkpoint = Math.floor(index / CHECKPOINT);
    const beliefs = new Map(this.checkpoints[checkpoint]);
    for (let i = checkpoint * CHECKPOINT; i <= index; i++) apply(beliefs, this.thoughts[i]);
    const steps = [];
    for (let i = index; i >= 0 && steps.length < RECENT_STEPS; i--) {
      const { t, steps: taken = [] } = this.thoughts[i];
      steps.unshift(...taken.filter(isNews).map(([kind, text, place]) => ({ t, kind, text, place })));
    }
    return {
      index, t: this.thoughts[index].t, beliefs, intentions: this.intents[index],
      steps: steps.slice(-RECENT_STEPS),
    };
  }
}

/** What the gantry is at: of the jobs that were started and not done, the latest. */
class Jobs {
  constructor(events) {
    const open = new Map();
    this.changes = [];
    for (const event of events) {
      if (event.kind === "job_started") open.set(jobKey(event), event);
      else if (event.kind === "job_done") open.delete(jobKey(event));
      else if (event.kind === "order_submitted") open.delete(jobKey({ ...event, job: "submit" }));
      else continue;
      this.changes.push({ t: event.t, job: [...open.values()].at(-1) });
    }
    this.times = Float64Array.from(this.changes, change => change.t);
  }

  /** The event that started the job at t, or undefined. */
  at(t) {
    return this.changes[lastUpTo(this.times, t)]?.job;
  }
}

function apply(believed, thought) {
  for (const text of thought.forgets ?? []) believed.delete(text);
  for (const text of thought.believes ?? []) believed.set(text, thought.t);
}

function jobKey({ t, kind, ...fields }) {
  return JSON.stringify(Object.entries(fields).sort());
}

/** Percepts that end are seen from the beliefs. */
const isNews = ([kind, text]) => kind !== "percept" || !text.startsWith("-");

const functor = text => text.split(/[([]/, 1)[0];
