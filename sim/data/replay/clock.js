/* The time of the replay. */

const SPEEDS = [0.25, 0.5, 1, 2, 4, 8, 16, 32, 64];
const LONGEST_FRAME = 0.1;     // seconds: a page that was suspended resumes where it was
const LIVE_LAG = 0.4;          // seconds of the viewer's time by which a live replay stays behind
const LIVE_LOST = 2;           // the same; with more it jumps ahead

/**
 * Runs at `speed` while it plays, up to the `frontier`, the part of the `duration` that is known.
 * While it `isLive`, it stays close to the frontier. `onChange` is called on every change.
 */
class Clock {
  constructor(duration, onChange) {
    Object.assign(this, { duration, frontier: duration, onChange, time: 0, speed: 1 });
    this.isPlaying = this.isLive = false;
    this.runSpeed = null;      // at which a run under way advances
    this.steer = null;         // lets it advance at another one
  }

  play() {
    if (this.time >= this.duration) this.time = 0;
    this.isPlaying = true;
    this.onChange();
  }

  pause() {
    this.isPlaying = this.isLive = false;
    this.onChange();
  }

  seek(t) {
    this.isLive = false;
    this.time = Math.min(Math.max(t, 0), this.frontier);
    this.onChange();
  }

  /** Follow the run under way, which advances at `speed`. */
  goLive(speed = this.runSpeed) {
    this.isLive = this.isPlaying = true;
    this.speed = this.runSpeed = speed;
    this.onChange();
  }

  /** `elapsed` seconds of the viewer's time have gone by. */
  advance(elapsed) {
    if (!this.isPlaying) return;
    const next = this.time + Math.min(elapsed, LONGEST_FRAME) * this.speed * this.#pace;
    const earliest = this.isLive ? this.frontier - LIVE_LOST * this.speed : 0;
    this.time = Math.min(Math.max(next, earliest), this.frontier);
    if (this.time === this.duration) this.pause();
  }

  /** A factor of the speed, which keeps the lag behind a run under way constant. */
  get #pace() {
    if (!this.isLive) return 1;
    const lag = (this.frontier - this.time) / this.speed;
    return 1 + Math.min(Math.max(lag - LIVE_LAG, -0.3), 0.5);
  }

  faster() { this.goAt(SPEEDS.find(speed => speed > this.speed)); }

  slower() { this.goAt(SPEEDS.findLast(speed => speed < this.speed)); }

  /** Goes on at another speed; while it is live, so does the run. */
  goAt(speed = this.speed) {
    if (this.isLive && this.steer) this.steer(speed);
    else this.speed = speed;
    this.onChange();
  }
}
