/* One recording: bodies and their motions, watches, violations, stops. */

const FEW = 4;               // people, of whom each pair can be looked at
const NEAR = 1;              // metres beyond the required distance, within which a pair is almost too near
const MOST_NEAR = 3;         // pairs beside the chosen one, of which the distances of many people are shown
const MEETINGS = ["met", "gave_way", "blocked"];
const PERSON_COLORS = ["person-1", "person-2", "person-3", "person-4"];

/** A body of the recording with its motion. */
class Body {
  constructor(data, pieces, color) {
    Object.assign(this, data);
    this.color = color;
    this.motion = new Motion(pieces);
    this.track = new Track(this.motion);
  }
}

/** One recording without its looks, known up to `known` (seconds). */
class Run {
  constructor(recording, known = recording.duration) {
    const { bodies, events, watches, duration } = recording;
    this.recording = recording;
    this.duration = duration;
    this.known = known;
    const { floorplan } = recording;
    const courses = [...floorplan.lanes.map(({ from, to }) => [from, to]), ...bodies.map(body => body.course)];
    this.plan = { ...floorplan, courses: courses.filter(Boolean) };
    this.events = events;
    this.bodies = new Map();
    let people = 0;
    for (const data of bodies) {
      const color = data.category === "person" ? PERSON_COLORS[people++ % PERSON_COLORS.length] : data.category;
      this.bodies.set(data.name, new Body(data, piecesOf(recording, data.name), color));
    }
    this.people = [...this.bodies.values()].filter(body => body.category === "person");
    const bounds = boxOf(floorplan.boundary);
    this.watches = [...watches, ...pairsOfPeople(this.people, events)]
      .map(watch => new Watch(watch, this.bodies, known, bounds));
    this.minds = new Map();
    this.changes = events.filter(event => event.kind === "personality_changed");
    this.goals = new Map();
    this.jobs = new Jobs(events);
    this.disabled = intervalsOf(events, known, DISABLES, ENABLES);
    this.occupied = intervalsOf(events, known, fieldOf("field_occupied"), fieldOf("field_free"));
    this.muted = intervalsOf(events, known, machineIn("fields_muted"), machineIn("fields_unmuted"));
    this.waits = waitsOf(events, known);
    this.held = intervalsOf(events, Infinity, commanded("hold"), commanded("release"));
    this.conveyed = conveyed(events);
    this.comings = comings(events, recording.passing);
    this.violations = this.#violations();
    this.violationTimes = this.violations.map(violation => violation.t);
  }

  /** The bodies whose speeds are shown without a pair: its people, or else its machines. */
  get paced() {
    return this.people.length ? this.people : [...this.bodies.values()];
  }

  /** The number of the pair that is shown first: the least margin, or else a violation. */
  get firstWatch() {
    const { person, machine } = this.recording.summary?.least_margin ?? {};
    const least = this.watches.findIndex(one => one.person.name === person && one.other.name === machine);
    return Math.max(0, least >= 0 ? least : this.watches.findIndex(watch => watch.violations.length));
  }

  /** The fields of density and speed of its people. */
  get fields() {
    return this.cachedFields ??= new Fields(this);
  }

  get title() {
    return this.recording.title ?? "";
  }

  /** What may tell this run from another one, by kind; what comes first says most. */
  get marks() {
    const { bodies, controller, folder, summary } = this.recording;
    const { rules, seed } = summary ?? {};
    const people = bodies.filter(body => body.personality);
    const whose = name => (people.length > 1 ? `${spoken(name)}: ` : "");
    return {
      title: this.title,
      ...Object.fromEntries(people.map(({ name, personality }) => (
        [`personality of ${name}`, `${whose(name)}${spoken(personality)}`]))),
      controller: controller && `controller ${controller}`,
      rules: rules && `rules ${rules}`,
      seed: seed !== undefined && `seed ${seed}`,
      folder,
    };
  }

  /** The watch here that is most like one of another run: the same names, or else the same categories. */
  watchLike(watch) {
    if (!watch) return undefined;
    return this.watches.find(own => own.name === watch.name)
      ?? this.watches.find(own => own.other.category === watch.other.category);
  }

  /** The name of a person's personality at t. */
  personality(person, t) {
    const changes = this.changes.filter(event => event.person === person.name && event.t <= t);
    return changes.at(-1)?.personality ?? person.personality ?? "unknown";
  }

  /** The mind of a person, undefined where it was not recorded. */
  mindOf(name) {
    const { minds } = this.recording;
    if (!this.minds.has(name)) this.minds.set(name, minds && name in minds ? new Mind(minds[name]) : undefined);
    return this.minds.get(name);
  }

  /** The event with which a person last set out, up to t. */
  goalOf(person, t) {
    const { times, events } = this.#goals(person.name);
    return events[lastUpTo(times, t)];
  }

  #goals(name) {
    if (!this.goals.has(name)) {
      const events = this.events.filter(event => event.kind === "goal" && event.person === name);
      this.goals.set(name, { events, times: events.map(event => event.t) });
    }
    return this.goals.get(name);
  }

  /**
   * The watches to show at t: of each person the chosen one (last, on top), or a violated one, or the first
   * there is. Of many people, only those nearest to their required distance.
   */
  shown(chosen, t) {
    const others = this.people.filter(person => person !== chosen?.person).map(person => {
      const mine = this.watches.filter(watch => watch.person === person);
      return mine.find(watch => watch.violatedAt(t)) ?? mine[0];
    }).filter(Boolean);
    return [...this.people.length > FEW ? nearest(others, t) : others, chosen].filter(Boolean);
  }

  /** The last violation of a watch that was counted, if that was within `afterglow` seconds. */
  violationLately(watch, t, afterglow) {
    for (let i = lastUpTo(this.violationTimes, t); i >= 0 && t - this.violationTimes[i] <= afterglow; i--) {
      if (this.violations[i].watch === watch) return this.violations[i].event;
    }
    return undefined;
  }

  /** True while a machine is disabled, or on hold. */
  isDisabled(body, t) {
    return isWithin(this.disabled.get(body.name), t) || this.isHeld(body, t);
  }

  /** True while somebody outside has a machine on hold. */
  isHeld({ name }, t) {
    return isWithin(this.held.get(name), t);
  }

  /** True while somebody is in a field of a machine, "protective" or "warning". */
  isOccupied({ name }, field, t) {
    return this.people.some(({ name: person }) => isWithin(this.occupied.get([name, field, person].join()), t));
  }

  /** True while the fields of a machine are muted. */
  isMuted({ name }, t) {
    return isWithin(this.muted.get(name), t);
  }

  /** What somebody outside has put down, and is there at t. */
  placedAt(t) {
    return thereAt(this, t).filter(thing => thing.isPlaced);
  }

  /** A name of that stem with a number that nothing here has yet. */
  freeName(stem) {
    const taken = [...this.plan.obstacles, ...this.plan.zones ?? [], ...this.comings.things, ...this.bodies.values()]
      .map(({ name }) => name);
    let number = 1;
    while (taken.includes(`${stem}${number}`)) number++;
    return `${stem}${number}`;
  }

  /** The body whose centre is nearest to a place of the floor, within `reach` metres. */
  bodyAt(t, x, y, reach) {
    const away = body => {
      const at = body.motion.at(t);
      return Math.hypot(at.x - x, at.y - y);
    };
    return [...this.bodies.values()].map(body => [away(body), body])
      .filter(([distance]) => distance <= reach).sort((a, b) => a[0] - b[0])[0]?.[1];
  }

  #violations() {
    return this.events.filter(event => event.kind === "violation" && this.bodies.has(event.person)).map(event => {
      const violation = {
        t: event.t,
        event,
        watch: this.watches.find(({ person, other }) => person.name === event.person && other.name === event.with),
      };
      onDemand(violation, "person", () => this.bodies.get(event.person).motion.before(event.t));
      onDemand(violation, "other", () => this.bodies.get(event.with)?.motion.before(event.t));
      return violation;
    });
  }
}

/** Of some watches those of the nearest people at t, who notice the other body or are almost too near. */
function nearest(watches, t) {
  const found = watches.map(watch => ({ watch, ...watch.at(t) }));
  return found.filter(({ distance, margin, notice }) => margin < NEAR || (notice !== null && distance < notice))
    .sort((a, b) => a.margin - b.margin).slice(0, MOST_NEAR).map(({ watch }) => watch);
}

/** The people of a recording and their personalities, many of them counted: "25 × calm". */
function castOf(people) {
  if (people.length <= FEW) return people.map(({ name, personality }) => `${spoken(name)}: ${personality}`);
  const counts = new Map();
  for (const { personality } of people) counts.set(personality, (counts.get(personality) ?? 0) + 1);
  return [...counts].map(([personality, count]) => `${count} × ${personality}`);
}

/** A name for each run: the title, or else what differs between them, as far as `most` kinds of it. */
function namesOf(runs, most = 2) {
  const marks = runs.map(run => run.marks);
  const kinds = [...new Set(marks.flatMap(Object.keys))]
    .filter(kind => new Set(marks.map(mark => mark[kind])).size > 1);
  const chosen = kinds[0] === "title" ? ["title"] : kinds.slice(0, most);
  return marks.map((mark, i) => chosen.map(kind => mark[kind]).filter(Boolean).join(", ") || runs[i].title);
}

/** Watches of two people each: all pairs of a few, and of many those who met. They touch at zero gap. */
function pairsOfPeople(people, events) {
  const met = new Set(events.filter(event => MEETINGS.includes(event.kind))
    .map(event => [event.person, event.other ?? event.to ?? event.by].sort().join()));
  return people.flatMap((person, i) => people.slice(i + 1)
    .filter(other => people.length <= FEW || met.has([person.name, other.name].sort().join()))
    .map(other => ({
      person: person.name, other: other.name, law: { distance: person.radius + other.radius }, violations: [],
    })));
}

const DISABLES = event => (
  event.kind === "gantry_disabled" || event.kind === "robot_malfunction" ? machineOf(event) : null);
const commanded = field => event => (event.kind === "commanded" ? event[field] : null);
const machineIn = kind => event => (event.kind === kind ? machineOf(event) : null);
const fieldOf = kind => event => (
  event.kind === kind ? [machineOf(event), event.field, event.person].join() : null);
const ENABLES = event => (event.kind === "gantry_enabled" ? machineOf(event) : null);

/** The times from an event with which one of a machine's begins to that with which it ends, by its name: {begins, ends}. */
function intervalsOf(events, end, beginsWith, endsWith) {
  const intervals = new Map();
  for (const event of events) {
    const isBegin = Boolean(beginsWith(event));
    const name = beginsWith(event) || endsWith(event);
    if (!name) continue;
    if (!intervals.has(name)) intervals.set(name, { begins: [], ends: [] });
    const { begins, ends } = intervals.get(name);
    const isOpen = begins.length > ends.length;
    if (isBegin && !isOpen) begins.push(event.t);
    if (!isBegin && isOpen) ends.push(event.t);
  }
  for (const { begins, ends } of intervals.values()) if (begins.length > ends.length) ends.push(end);
  return intervals;
}

const isWithin = (intervals, t) => intervals !== undefined && t < intervals.ends[lastUpTo(intervals.begins, t)];
