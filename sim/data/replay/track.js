/* A motion as points to draw: the path behind a body and the path ahead of it. */

const TRACK_WINDOW = 60;     // seconds before and after an instant for which points are worked out

/**
 * A motion as points to draw, cut into legs: a leg is a stretch without a stop or a jump. The points
 * are worked out round the instant that is asked for, so that a long recording opens as fast as a short one.
 */
class Track {
  constructor(motion) {
    this.motion = motion;
    this.begin = Infinity;     // the points hold for instants from `begin` to `end`, seconds
    this.end = -Infinity;
    this.leg = null;           // the one that was asked for last
  }

  /** Works out the points from `since` to the end of the leg at t, and some more on both sides. */
  #cover(since, t) {
    if (this.begin <= since && t <= this.end) return;
    const { motion } = this;
    const first = Math.max(0, motion.upTo(since - TRACK_WINDOW));
    this.begin = first === 0 ? -Infinity : motion.begins[first];
    this.end = t + TRACK_WINDOW;
    const times = [];
    const legs = [];
    let leg = -1;
    for (let i = first; i < motion.count; i++) {
      const begin = motion.begins[i];
      const end = motion.ends[i];
      const still = [1, 2, 3, 5, 6, 7].every(k => motion.coefficients[12 * i + k] === 0);
      if (still || end === begin) continue;
      const goesOn = times.at(-1) === begin && motion.lastJump(begin)?.t !== begin
        && motion.before(begin).speed > STILL;
      if (!goesOn) {
        if (begin > this.end) break;
        leg += 1;
        times.push(begin);
        legs.push(leg);
      }
      const steps = Math.ceil((end - begin) / TRACK_STEP);
      for (let k = 1; k <= steps; k++) {
        times.push(begin + (end - begin) * (k / steps));
        legs.push(leg);
      }
    }
    const places = times.map((t, i) => (legs[i + 1] === legs[i] ? motion.at(t) : motion.before(t)));
    this.times = Float64Array.from(times);
    this.legs = Int32Array.from(legs);
    this.xs = Float64Array.from(places, place => place.x);
    this.ys = Float64Array.from(places, place => place.y);
    this.leg = null;
  }

  /**
   * The leg at t, null where the body stands: of its points {times, xs, ys} and `rests`, the metres from each to
   * the last one. As long as it is the same leg, it is the same object.
   */
  legAt(t) {
    this.#cover(t, t);
    const { legs } = this;
    const at = lastUpTo(this.times, t);
    if (at < 0 || legs[at + 1] !== legs[at]) return null;
    if (this.leg?.number === legs[at]) return this.leg;
    let [first, end] = [at, at + 1];
    while (legs[first - 1] === legs[at]) first--;
    while (legs[end] === legs[at]) end++;
    const [times, xs, ys] = [this.times, this.xs, this.ys].map(all => all.subarray(first, end));
    const rests = new Float64Array(times.length);
    for (let i = rests.length - 2; i >= 0; i--) {
      rests[i] = rests[i + 1] + Math.hypot(xs[i + 1] - xs[i], ys[i + 1] - ys[i]);
    }
    return this.leg = { number: legs[at], times, xs, ys, rests };
  }

  /**
   * The path of the `seconds` before t: calls `draw(points, age)` for each stretch without a
   * stop or a jump, cut so that no stretch is longer than `grain` seconds; oldest first.
   */
  behind(t, seconds, grain, draw) {
    this.#cover(t - seconds, t);
    const first = lastUpTo(this.times, t - seconds) + 1;
    const last = lastUpTo(this.times, t);
    let points = [];
    let since = first;
    for (let i = first; i <= last; i++) {
      points.push([this.xs[i], this.ys[i]]);
      const isCut = this.legs[i + 1] !== this.legs[i];
      if (i === last && !isCut) {
        const here = this.motion.at(t);
        points.push([here.x, here.y]);
      }
      if (isCut || i === last || this.times[i] - this.times[since] >= grain) {
        if (points.length > 1) draw(points, t - this.times[i]);
        points = isCut ? [] : [[this.xs[i], this.ys[i]]];
        since = isCut ? i + 1 : i;
      }
    }
  }

  /** The points still ahead at t until the body stops: [[x, y], …], from where it is; [] if it stands. */
  ahead(t) {
    const leg = this.legAt(t);
    if (!leg) return [];
    const here = this.motion.at(t);
    const points = [[here.x, here.y]];
    for (let i = lastUpTo(leg.times, t) + 1; i < leg.times.length; i++) points.push([leg.xs[i], leg.ys[i]]);
    return points;
  }
}
