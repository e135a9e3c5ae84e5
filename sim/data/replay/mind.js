/* The mind of a person and the job of a gantry at t, from their changes. */

const CHECKPOINT = 50;        // thoughts between two copies of all beliefs
const RECENT_STEPS = 6;       // percepts, plans and actions that are shown

/** A person's beliefs, intentions, percepts and actions at any instant. */
class Mind {
  constructor(thoughts) {
    this.thoughts = thoughts;
    this.times = Float64Array.from(thoughts, thought => thought.t);
    this.changing = new Set();       // functors of beliefs that come and go
    this.checkpoints = [];           // beliefs before every so many thoughts
    this.intents = [];               // of each thought: the intentions after it
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

  /** {index, t, beliefs: Map of text to its instant, intentions, steps: [{t, kind, text, place}]}. */
  at(t) {
    const index = lastUpTo(this.times, t + 1e-9);
    if (this.latest.index !== index) this.latest = this.#after(index);
    return this.latest;
  }

  /** True if a belief is one of those that come and go. */
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

/** The job of a gantry: the latest that was started and is not done. */
class Jobs {
  constructor(events) {
    const open = new Map();
    this.changes = new Map();
    for (const event of events) {
      if (event.kind === "job_started") open.set(jobKey(event), event);
      else if (event.kind === "job_done") open.delete(jobKey(event));
      else if (event.kind === "order_submitted") open.delete(jobKey({ ...event, job: "submit" }));
      else continue;
      const machine = machineOf(event);
      const job = [...open.values()].filter(one => machineOf(one) === machine).at(-1);
      if (!this.changes.has(machine)) this.changes.set(machine, []);
      this.changes.get(machine).push({ t: event.t, machine, job });
    }
    this.times = new Map([...this.changes].map(([name, changes]) => [name, Float64Array.from(changes, ({ t }) => t)]));
  }

  /** The event that started the job of a machine at t, or undefined. */
  of(machine, t) {
    return this.changes.get(machine)?.[lastUpTo(this.times.get(machine), t)]?.job;
  }

  /** The machine whose job is shown: the one that is `wanted` if it has jobs, or else the one that began last. */
  shown(wanted, t) {
    if (this.changes.has(wanted)) return wanted;
    const begun = [...this.changes.keys()].map(machine => ({ machine, t: this.of(machine, t)?.t ?? -1 }));
    return begun.sort((a, b) => b.t - a.t)[0].machine;
  }
}

function apply(believed, thought) {
  for (const text of thought.forgets ?? []) believed.delete(text);
  for (const text of thought.believes ?? []) believed.set(text, thought.t);
}

function jobKey({ t, kind, ...fields }) {
  return JSON.stringify(Object.entries(fields).sort());
}

/** Percepts that end are left out: the beliefs show them. */
const isNews = ([kind, text]) => kind !== "percept" || !text.startsWith("-");

const functor = text => text.split(/[([]/, 1)[0];
