/* A place on the floor, or a box there, chosen by keyboard. */

const STRIDE_OF_KEY = 0.25;    // metres of a move, and of a change of size
const BESIDE = 3;              // metres up to which a station is named beside a place
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/**
 * Moves a box by the arrow keys (with Shift it grows and shrinks) while its element has the focus. `on` has
 * `move(words)` for each change and `put()` for Enter or the space bar.
 */
class Placing {
  constructor(element, on) {
    Object.assign(this, { element, on, at: null, size: [BOX, BOX], hasSize: false });
    element.addEventListener("keydown", event => this.#press(event));
  }

  /** Begins in the middle of what is seen of the floor; `hasSize` for a box. */
  begin(replay, hasSize) {
    Object.assign(this, { replay, hasSize, size: [BOX, BOX] });
    const { camera, above } = replay.views[0];
    const { left, right, bottom, top } = above.camera.bounds;
    const { screen } = camera;
    const middle = camera.onFloor((screen.left + screen.right) / 2, (screen.top + screen.bottom) / 2);
    const [x, y] = middle ?? [(left + right) / 2, (bottom + top) / 2];
    this.at = [Math.min(Math.max(x, left), right), Math.min(Math.max(y, bottom), top)]
      .map(metres => Math.round(metres / STRIDE_OF_KEY) * STRIDE_OF_KEY);
    this.element.hidden = false;
    this.#show();
  }

  end() {
    this.element.hidden = true;
    this.at = null;
  }

  /** Two corners of the box, or twice the place. */
  get corners() {
    const [half, deep] = this.hasSize ? this.size.map(side => side / 2) : [0, 0];
    const [x, y] = this.at;
    return [[x - half, y - deep], [x + half, y + deep]];
  }

  #press(event) {
    const arrow = ARROWS[event.key];
    if (!this.at || event.ctrlKey || event.metaKey || event.altKey) return;
    if (!arrow && event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    event.stopPropagation(); // or the arrows move the time
    if (!arrow) {
      this.on.put();
      return;
    }
    const by = side => arrow[side] * STRIDE_OF_KEY;
    if (event.shiftKey && this.hasSize) this.size = this.size.map((size, side) => Math.max(STRIDE_OF_KEY, size + by(side)));
    else this.at = this.at.map((metres, side) => metres + by(side));
    this.#show();
    this.#keepInView();
  }

  #show() {
    const words = this.inWords;
    write(this.element, words);
    this.on.move(words);
  }

  get inWords() {
    const [run] = this.replay.runs;
    const [x, y] = this.at;
    const box = this.hasSize ? `${this.size.map(side => fixed(side, 2)).join(" × ")} m at ` : "";
    const under = [...run.plan.obstacles, ...thereAt(run, run.known)].find(({ footprint }) => isInside(footprint, x, y));
    const [near] = run.plan.stations.map(({ name, at }) => ({ name, off: Math.hypot(at[0] - x, at[1] - y) }))
      .sort((a, b) => a.off - b.off);
    const where = [
      `x ${fixed(x, 2)}, y ${fixed(y, 2)} m`,
      !isInside(run.plan.boundary, x, y) && "outside the floor",
      under && `on ${spoken(under.name)}`,
      near?.off <= BESIDE && `${fixed(near.off, 1)} m from ${spoken(near.name)}`,
    ];
    return box + where.filter(Boolean).join(", ");
  }

  /** Moves the floor where the place would be off the screen. */
  #keepInView() {
    const [view] = this.replay.views;
    const place = view.camera.toScreen(...this.at, 0);
    if (!place || this.replay.isInSpace) return;
    const { clientWidth, clientHeight } = view.canvas;
    const [dx, dy] = [clientWidth, clientHeight].map((end, side) => (
      place[side] < 0 || place[side] > end ? end / 2 - place[side] : 0));
    if (dx || dy) view.camera.pan(dx, dy);
  }
}
