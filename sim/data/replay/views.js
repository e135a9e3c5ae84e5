/* The views of one run: from above, and in three dimensions; one of them is shown. */

/**
 * `on` has the actions when the user moves what is seen by (dx, dy) pixels (`pan`), goes round it (`orbit`),
 * zooms by a factor at a pixel (`zoom`), points somewhere (`point`) or clicks (`pick`).
 * `grab` takes a press away from all of these, if it returns {move, end, cancel}.
 */
class Views {
  constructor(run, frame, on, onResize) {
    const [flat, space, marks] = frame.querySelectorAll("canvas");
    Object.assign(this, { run, on, onResize, frame, space, marks });
    this.above = new View(run, flat, onResize);
    this.inSpace = null;
    this.shown = this.above;
    this.#wire(flat);
    this.#wire(marks);
  }

  get camera() { return this.shown.camera; }

  get canvas() { return this.shown.canvas; }

  get isInSpace() { return this.shown !== this.above; }

  /** Shows three dimensions or the floor from above; throws an Error where there is no WebGL 2. */
  showSpace(isWanted, onLost) {
    if (isWanted) this.inSpace ??= new SpaceView(this.run, this, this.onResize, onLost);
    this.shown = isWanted ? this.inSpace : this.above;
    this.frame.classList.toggle("spatial", isWanted);
  }

  /** WebGL was taken away: there is only the floor from above, until somebody asks again. */
  loseSpace() {
    this.showSpace(false);
    this.inSpace = null;
    const fresh = this.space.cloneNode();
    this.space.replaceWith(fresh);
    this.space = fresh;
  }

  show(run) {
    this.run = run;
    for (const view of this.#all) view.show(run);
  }

  follow(name) {
    for (const view of this.#all) view.follow(name);
  }

  lookThrough(person) {
    this.inSpace?.lookThrough(person);
  }

  restyle(palette) { this.shown.restyle(palette); }

  showField(scale) { this.shown.showField(scale); }

  draw(t, chosen, afterglow) { this.shown.draw(t, chosen, afterglow); }

  describe(px, py, t) { return this.shown.describe(px, py, t); }

  inWords(t) { return this.shown.inWords(t); }

  get #all() {
    return [this.above, this.inSpace].filter(Boolean);
  }

  #wire(canvas) {
    const { on } = this;
    wireGestures(canvas, {
      drag: (dx, dy, event) => {
        const isTurned = this.isInSpace && !event.shiftKey && event.buttons !== 2 && event.buttons !== 4;
        if (isTurned) on.orbit(dx, dy);
        else on.pan(dx, dy);
      },
      slide: on.pan,
      zoom: on.zoom,
      point: event => on.point(this, event),
      grab: (px, py) => on.grab(this, px, py),
      click: (px, py) => on.pick(this, t => this.shown.bodyAt(px, py, t)),
    });
  }
}
