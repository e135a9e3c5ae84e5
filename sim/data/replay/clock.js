/* The time of the replay. */

const SPEEDS = [0.25, 0.5, 1, 2, 4, 8, 16, 32, 64];
const LONGEST_FRAME = 0.1;     // seconds: a page that was asleep goes on where it was

/** Goes on at `speed` while it plays; `onChange` is called whenever something changes. */
class Clock {
  constructor(duration, onChange) {
    Object.assign(this, { duration, onChange, time: 0, speed: 1, isPlaying: false });
  }

  play() {
    if (this.time >= this.duration) this.time = 0;
    this.isPlaying = true;
    this.onChange();
  }

  pause() {
    this.isPlaying = false;
    this.onChange();
  }

  seek(t) {
    this.time = Math.min(Math.max(t, 0), this.duration);
    this.onChange();
  }

  /** `elapsed` seconds of the viewer's time have gone by. */
  advance(elapsed) {
    if (!this.isPlaying) return;
    this.time = Math.min(this.time + Math.min(elapsed, LONGEST_FRAME) * this.speed, this.duration);
    if (this.time === this.duration) this.pause();
  }

  changeSpeed(steps) {
    const i = SPEEDS.indexOf(this.speed) + steps;
    this.speed = SPEEDS[Math.min(Math.max(i, 0), SPEEDS.length - 1)];
    this.onChange();
  }
}
