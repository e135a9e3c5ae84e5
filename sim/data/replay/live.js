/* A run under way: its messages are added to the recording. */

const REDRAW = 250;            // milliseconds between two updates, at least

/**
 * Follows the stream at `address`: `onGrow(recording, now)` from time to time, `onPace({speed, paused})` where that
 * changes, `onEnd(recording)`.
 */
class Live {
  constructor(address, recording, onGrow, onPace, onEnd, onLost) {
    Object.assign(this, { recording, onGrow, onPace, now: 0, timer: null });
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

  #take({ now, event, motion, thought, violations, pace }) {
    const { recording } = this;
    if (pace) this.onPace(pace);
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

/** A page that was made for a run under way follows it until it is over. */
function followStream(replay, recording) {
  const { stream, speed } = document.documentElement.dataset;
  $("live").hidden = false;
  replay.grow(new Run(recording, 0));
  replay.clock.goLive(Number(speed));
  const control = new Control(replay);
  const end = words => {
    control.end();
    $("live").hidden = true;
    replay.clock.isLive = false;
    write($("subtitle"), words);
  };
  new Live(stream, recording,
    (grown, now) => replay.grow(new Run(grown, now)),
    pace => control.keepPace(pace),
    whole => {
      replay.grow(new Run(whole));
      end("the run is over");
    },
    () => end("the run is gone: the connection was lost"));
}
