/* A run under way: its messages are added to the recording. */

const REDRAW = 250;            // milliseconds between two updates, at least

/** Follows the stream at `address`: `onGrow(recording, now)` from time to time, `onEnd(recording)`. */
class Live {
  constructor(address, recording, onGrow, onEnd, onLost) {
    Object.assign(this, { recording, onGrow, now: 0, timer: null });
    this.source = new EventSource(address);
    this.source.onmessage = message => this.#take(JSON.parse(message.data));
    this.source.addEventListener("finished", message => {
      this.#close();
      onEnd(parseRecording(message.data));
    });
    this.source.onerror = () => {
      this.#close();
      onLost();
    };
  }

  #close() {
    this.source.close();
    clearTimeout(this.timer);
  }

  #take({ now, event, motion, thought, violations }) {
    const { recording } = this;
    if (now !== undefined) this.now = now;
    if (event) recording.events.push(event);
    if (motion) replaceFrom(recording.motions[motion.body], motion.pieces);
    if (thought) (recording.minds[thought.person] ??= []).push(thought);
    if (violations) recording.watches[violations.watch].violations = violations.intervals;
    this.timer ??= setTimeout(() => {
      this.timer = null;
      this.onGrow(recording, this.now);
    }, REDRAW);
  }
}

/** Replaces the pieces that were planned for the same time by new ones. */
function replaceFrom(pieces, more) {
  const [[begin]] = more;
  while (pieces.length && pieces.at(-1)[0] >= begin) pieces.pop();
  if (pieces.length) pieces.at(-1)[1] = Math.min(pieces.at(-1)[1], begin);
  pieces.push(...more);
}
