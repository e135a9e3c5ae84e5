/* A motion as points to draw: the way behind a body and the way ahead of it. */

/** A motion as points to draw, cut into legs: a leg is a stretch without a stop or a jump. */
class Track {
  constructor(motion) {
    const times = [];
    const legs = [];
    let leg = -1;
    for (let i = 0; i < motion.begins.length; i++) {
      const begin = motion.begins[i];
      const end = motion.ends[i];
      const still = [1, 2, 3, 5, 6, 7].every(k => motion.coefficients[12 * i + k] === 0);
      if (still || end === begin) continue;
      const goesOn = times.at(-1) === begin && motion.lastJump(begin)?.t !== begin
        && motion.before(begin).speed > STILL;
      if (!goesOn) {
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
    this.motion = motion;
    this.times = Float64Array.from(times);
    this.legs = Int32Array.from(legs);
    this.xs = Float64Array.from(places, place => place.x);
    this.ys = Float64Array.from(places, place => place.y);
  }

  /** What was walked from t - seconds to t: calls line(x0, y0, x1, y1, age) for each bit, oldest first. */
  behind(t, seconds, line) {
    const from = t - seconds;
    const first = Math.max(1, lastUpTo(this.times, from) + 1);
    const last = lastUpTo(this.times, t);
    for (let i = first; i <= last; i++) {
      if (this.legs[i] !== this.legs[i - 1]) continue;
      line(this.xs[i - 1], this.ys[i - 1], this.xs[i], this.ys[i], t - this.times[i]);
    }
    if (last >= 0 && last + 1 < this.times.length && this.legs[last + 1] === this.legs[last]) {
      const here = this.motion.at(t);
      line(this.xs[last], this.ys[last], here.x, here.y, 0);
    }
  }

  /** The points still ahead at t until the body stops: [[x, y], …], from where it is; [] if it stands. */
  ahead(t) {
    const last = lastUpTo(this.times, t);
    if (last < 0 || this.legs[last + 1] !== this.legs[last]) return [];
    const here = this.motion.at(t);
    const points = [[here.x, here.y]];
    for (let i = last + 1; this.legs[i] === this.legs[last]; i++) points.push([this.xs[i], this.ys[i]]);
    return points;
  }
}
