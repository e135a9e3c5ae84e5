/* The pose of a body at t, in closed form. */

const JUMP = 1e-6;          // metres: a smaller gap between two pieces is rounding
const STILL = 1e-6;         // m/s: a smaller speed is rounding
const TRACK_STEP = 0.1;     // seconds between the points of a drawn track

/** The index of the last of the ascending `times` that is <= t, or -1. */
function lastUpTo(times, t) {
  return firstWhere(times, time => time > t) - 1;
}

/** The index of the last of the ascending `times` that is < t, or -1. */
function lastBefore(times, t) {
  return firstWhere(times, time => time >= t) - 1;
}

/** The index of the first of `times` that is late; those from `low` on, and before `high`, are looked at. */
function firstWhere(times, isLate, low = 0, high = times.length) {
  while (low < high) {
    const middle = (low + high) >> 1;
    if (isLate(times[middle])) high = middle;
    else low = middle + 1;
  }
  return low;
}

/** A function of time: cubic pieces, still between them, before the first and after the last. */
class Motion {
  constructor(pieces) {
    const count = pieces.length;
    this.count = count;
    if (pieces instanceof PackedPieces) {
      ({ begins: this.begins, ends: this.ends, coefficients: this.coefficients } = pieces);
      return;
    }
    this.begins = new Float64Array(count);
    this.ends = new Float64Array(count);
    this.coefficients = new Float64Array(12 * count);   // x0…x3, y0…y3, r0…r3 of each
    pieces.forEach((piece, i) => {
      this.begins[i] = piece[0];
      this.ends[i] = piece[1];
      for (let axis = 0; axis < 3; axis++) this.coefficients.set(piece[2 + axis], 12 * i + 4 * axis);
    });
  }

  /** The number of the last piece that begins at t or before, or -1. */
  upTo(t) {
    return lastUpTo(this.begins, t);
  }

  /** Pose and velocity at t; at a change, those after it. */
  at(t) {
    const i = Math.max(0, this.upTo(t));
    return this.#state(i, t, this.begins[i] <= t && t < this.ends[i]);
  }

  /** Pose and velocity just before t: at a change, those that led up to it. */
  before(t) {
    const i = Math.max(0, lastBefore(this.begins, t));
    return this.#state(i, t, this.begins[i] < t && t <= this.ends[i]);
  }

  #state(i, t, moving) {
    const u = Math.min(Math.max(t, this.begins[i]), this.ends[i]) - this.begins[i];
    const c = this.coefficients;
    const k = 12 * i;
    const vx = moving ? c[k + 1] + u * (2 * c[k + 2] + u * 3 * c[k + 3]) : 0;
    const vy = moving ? c[k + 5] + u * (2 * c[k + 6] + u * 3 * c[k + 7]) : 0;
    return {
      x: c[k] + u * (c[k + 1] + u * (c[k + 2] + u * c[k + 3])),
      y: c[k + 4] + u * (c[k + 5] + u * (c[k + 6] + u * c[k + 7])),
      rotation: c[k + 8] + u * (c[k + 9] + u * (c[k + 10] + u * c[k + 11])),
      vx, vy, speed: Math.hypot(vx, vy),
      turning: moving ? c[k + 9] + u * (2 * c[k + 10] + u * 3 * c[k + 11]) : 0,
    };
  }

  /** The heading at t, turned gently where it changes at once: the mean over `window` seconds. */
  heading(t, window = 0.4) {
    let c = 0;
    let s = 0;
    for (let k = -4; k <= 4; k++) {
      const { rotation } = this.at(t + (k / 8) * window);
      const weight = 5 - Math.abs(k);
      c += weight * Math.cos(rotation);
      s += weight * Math.sin(rotation);
    }
    return Math.hypot(c, s) > 1e-9 ? Math.atan2(s, c) : this.at(t).rotation;
  }

  /** The last jump up to t: {t, from, to}, or undefined. */
  lastJump(t) {
    const i = this.jumps[lastUpTo(this.jumps, this.upTo(t))];
    if (i === undefined) return undefined;
    const { begins, ends } = this;
    return { t: begins[i], from: this.#state(i - 1, ends[i - 1], false), to: this.#state(i, begins[i], false) };
  }

  /** The times of the jumps from one instant to another. */
  jumpsIn(from, to) {
    const [first, last] = [this.upTo(from), this.upTo(to)];
    return this.jumps.filter(i => i >= first && i <= last).map(i => this.begins[i]);
  }

  get jumps() {
    return this.cachedJumps ??= this.#findJumps();
  }

  /** The numbers of the pieces that do not begin where the one before ended. */
  #findJumps() {
    const jumps = [];
    const { begins, ends, coefficients: c } = this;
    const atEnd = (k, u) => c[k] + u * (c[k + 1] + u * (c[k + 2] + u * c[k + 3]));
    for (let i = 1; i < begins.length; i++) {
      const [k, u] = [12 * i, ends[i - 1] - begins[i - 1]];
      const [dx, dy] = [c[k] - atEnd(k - 12, u), c[k + 4] - atEnd(k - 8, u)];
      if (dx * dx + dy * dy > JUMP * JUMP) jumps.push(i);
    }
    return jumps;
  }
}
