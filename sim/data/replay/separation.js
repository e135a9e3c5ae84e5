/* The distance of two bodies, and the required distance. */

const SAMPLES = 1200;        // of a curve, beside the changes of motion
const MOST_CHANGES = 3;      // of the motions in a pixel of a curve; with more it is drawn in columns

/** The distance that a law requires: ISO/TS 15066 in linear form, fixed, or along a curve of time.
 *  Speeds in m/s; `before` asks for the value just before t, where the curve jumps. */
function requiredDistance(law, personSpeed, otherSpeed, t, before) {
  if ("curve" in law) return along(law.curve, t, before);
  if ("distance" in law) return law.distance;
  return personSpeed * (law.t1 + law.t2) + otherSpeed * law.t1 + law.stopping + law.intrusion;
}

/** The height of a curve of points [t, y] at t, straight between them. */
function along(curve, t, before) {
  const low = firstWhere(curve, ([time]) => (before ? time >= t : time > t));
  if (low === 0) return curve[0][1];
  const [t0, y0] = curve[low - 1];
  if (low === curve.length) return y0;
  const [t1, y1] = curve[low];
  return y0 + ((y1 - y0) * (t - t0)) / (t1 - t0);
}

/** The names of the pair of a watch, if it is not the `chosen` one; else "". */
function pairOf(watch, chosen) {
  if (watch?.name === chosen?.name) return "";
  return watch ? watch.name : "no such pair";
}

/** The distance (m) of a point from a polygon of corners, 0 inside: they are convex and counterclockwise. */
function toPolygon(corners, x, y) {
  let nearest = Infinity;
  corners.forEach(([ax, ay], i) => {
    const [bx, by] = corners[(i + 1) % corners.length];
    const [dx, dy] = [bx - ax, by - ay];
    if (dx * (y - ay) >= dy * (x - ax)) return;
    const share = Math.min(Math.max(((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy), 0), 1);
    nearest = Math.min(nearest, Math.hypot(x - ax - share * dx, y - ay - share * dy));
  });
  return nearest === Infinity ? 0 : nearest;
}

/** The distance (m) between the surfaces of a person and a machine, with its arm's circle, on the floor. */
function betweenSurfaces({ radius, corners, reach }, person, machine) {
  const [dx, dy] = [person.x - machine.x, person.y - machine.y];
  const [c, s] = [Math.cos(machine.rotation), Math.sin(machine.rotation)];
  const arm = reach > 0 ? Math.hypot(dx, dy) - reach : Infinity;
  return Math.max(Math.min(toPolygon(corners, c * dx + s * dy, c * dy - s * dx), arm) - radius, 0);
}

const WORDS_OF_MACHINES = { distance: "distance", required: "required", margin: "margin" };
const WORDS_OF_SURFACES = { distance: "clearance", required: "required", margin: "margin" };
const WORDS_OF_PEOPLE = { distance: "distance", required: "touch at", margin: "gap" };

/** One person and one other body, and the law between them. */
class Watch {
  constructor(data, bodies, duration, bounds) {
    this.duration = duration;
    this.bounds = bounds;
    this.person = bodies.get(data.person);
    this.other = bodies.get(data.other);
    this.law = data.law;
    this.noticeLaw = data.notice_law ?? data.law;
    this.noticeFactor = data.notice ?? null;
    this.noticeCap = data.notice_cap ?? Infinity;
    this.measuredAt = data.measured_at ?? [0, 0];
    this.surfaces = data.surfaces ?? null;
    this.added = this.surfaces?.radius ?? 0;       // to distances, of a disc round the person
    this.violations = [...data.violations].sort((a, b) => a[0] - b[0]);
    this.violationBegins = this.violations.map(violation => violation[0]);
    this.name = `${spoken(data.person)} – ${spoken(data.other)}`;
    this.isOfPeople = this.other.category === "person";
    this.words = this.isOfPeople ? WORDS_OF_PEOPLE : this.surfaces ? WORDS_OF_SURFACES : WORDS_OF_MACHINES;
  }

  /** Distances in metres as the rules measure them, speeds in m/s; `notice` is null where there is no
   *  noticing distance, `distance` and `margin` are NaN while one of the two is not on the floor. */
  at(t) {
    return this.#between(this.person.motion.at(t), this.other.motion.at(t), t);
  }

  /** The same, just before t. */
  before(t) {
    return this.#between(this.person.motion.before(t), this.other.motion.before(t), t, true);
  }

  #between(person, other, t, before = false) {
    const distance = isAway(person, this) || isAway(other, this) ? NaN : this.#distance(person, other);
    const required = requiredDistance(this.law, person.speed, other.speed, t, before);
    const notice = this.noticeFactor === null
      ? null : this.noticeFactor * Math.min(
        requiredDistance(this.noticeLaw, person.speed, other.speed, t, before), this.noticeCap);
    return {
      distance, required, margin: distance - required, notice,
      personSpeed: person.speed, otherSpeed: other.speed, violated: this.violatedAt(t),
    };
  }

  #distance(person, other) {
    if (this.surfaces) return betweenSurfaces(this.surfaces, person, other);
    const [dx, dy] = this.measuredAt;
    return Math.hypot(person.x - other.x - dx, person.y - other.y - dy);
  }

  /** True if at t the two are too close, by the rules. */
  violatedAt(t) {
    const i = lastUpTo(this.violationBegins, t);
    return i >= 0 && t < this.violations[i][1];
  }

  /** Curves from one instant to another, with both sides of every change: cut where a body jumps. */
  curves(from, to) {
    if (this.sampled?.from !== from || this.sampled.to !== to) {
      this.sampled = { from, to, curves: this.#sample(from, to) };
    }
    return this.sampled.curves;
  }

  /** True if from one instant to another the motions change too often for a curve of so many pixels. */
  isDense(from, to, pixels) {
    const changes = [this.person.motion, this.other.motion].reduce((sum, motion) => (
      sum + motion.upTo(to) - motion.upTo(from)), 0);
    return changes > MOST_CHANGES * pixels;
  }

  /**
   * The same as `columns` of equal time: of each its middle `t`, the nearest and the farthest distance, the
   * largest required distance, and if in it there was a violation.
   */
  columns(from, to, columns) {
    const kept = this.thinned;
    if (kept?.from === from && kept.to === to && kept.columns.length === columns) return kept.columns;
    const span = (to - from) / columns;
    const found = Array.from({ length: columns }, (_, i) => ({
      t: from + (i + 0.5) * span, nearest: Infinity, farthest: -Infinity, required: 0, violated: false,
    }));
    const { times, distances, requirements } = this.#whole;
    for (let i = firstWhere(times, t => t >= from); i < times.length && times[i] <= to; i++) {
      if (Number.isNaN(distances[i])) continue;
      const column = found[Math.min(columns - 1, Math.floor((times[i] - from) / span))];
      column.nearest = Math.min(column.nearest, distances[i]);
      column.farthest = Math.max(column.farthest, distances[i]);
      column.required = Math.max(column.required, requirements[i]);
    }
    for (const [begin, end] of this.violations) {
      const last = Math.min(columns - 1, Math.floor((end - from) / span));
      for (let i = Math.max(0, Math.floor((begin - from) / span)); i <= last; i++) found[i].violated = true;
    }
    this.thinned = { from, to, columns: found };
    return found;
  }

  /** The largest distance and required distance of the whole run. */
  get largest() {
    const highest = values => values.reduce((most, value) => (value > most ? value : most), 0);
    return this.cachedLargest ??= {
      distance: highest(this.#whole.distances), required: highest(this.#whole.requirements),
    };
  }

  /** The curves of the whole run, without where they are cut, as arrays: {times, distances, requirements}. */
  get #whole() {
    return this.cachedWhole ??= this.#sampleWhole();
  }

  #sampleWhole() {
    const instants = this.#instants(0, this.duration);
    const [times, distances, requirements] = [0, 1, 2].map(() => new Float64Array(2 * instants.length));
    instants.forEach((t, k) => {
      [this.before(t), this.at(t)].forEach(({ distance, required }, side) => {
        const i = 2 * k + side;
        times[i] = t;
        distances[i] = distance;
        requirements[i] = required;
      });
    });
    return { times, distances, requirements };
  }

  /** Instants at equal steps, and those at which a motion changes, in order. */
  #instants(from, to) {
    const times = Array.from({ length: SAMPLES + 1 }, (_, i) => from + ((to - from) * i) / SAMPLES);
    for (const motion of [this.person.motion, this.other.motion]) {
      for (let i = motion.upTo(from) + 1; i < motion.count; i++) {
        if (motion.begins[i] >= to) break;
        times.push(motion.begins[i]);
      }
    }
    return Float64Array.from(times).sort().filter((t, i, all) => t !== all[i - 1]);
  }

  #sample(from, end) {
    const motions = [this.person.motion, this.other.motion];
    const to = Math.max(from, Math.min(end, this.duration));
    const jumps = new Set(motions.flatMap(motion => motion.jumpsIn(from, to)));
    const curves = [];
    let curve = [];
    for (const t of this.#instants(from, to)) {
      curve.push({ t, ...this.before(t) });
      if (jumps.has(t)) {
        curves.push(curve);
        curve = [];
      }
      curve.push({ t, ...this.at(t) });
    }
    return [...curves, curve];
  }
}
