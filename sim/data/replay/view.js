/* One run on a canvas, from above: the floor and the bodies. */

const FOLLOW_SCALE = 45;       // pixels a metre, at least, when a body is followed

class View {
  constructor(run, canvas, onResize) {
    this.canvas = canvas;
    this.followed = null;
    this.camera = new Camera(boxOf(run.plan.boundary));
    this.surface = new Surface(canvas, onResize);
    this.show(run);
  }

  /** Shows another run on the same floor. */
  show(run) {
    this.run = run;
    this.layer = new FloorLayer(run.plan);
  }

  /** Shows a field over the floor (null: none). */
  showField(scale) { this.fieldScale = scale; }

  /** What its canvas is drawn with. */
  get pen() { return { context: this.surface.context, palette: this.palette }; }

  /** Keeps the body of that name in the middle; "" for none. */
  follow(name) {
    this.followed = this.run.bodies.get(name) ?? null;
    if (this.followed) this.camera.scale = Math.max(this.camera.scale, FOLLOW_SCALE);
  }

  /** The colours or the size have changed. */
  restyle(palette) {
    this.palette = palette;
    this.surface.fit();
    this.hatch = hatching(this.surface.context, palette.danger, this.surface.ratio);
    this.layer.invalidate();
    this.camera.resize(this.surface);
  }

  draw(t, chosen, afterglow) {
    const { camera, palette, hatch } = this;
    if (this.followed) {
      const { x, y } = this.run.bodies.get(this.followed.name).motion.at(t);
      camera.lookAt(x, y);
    }
    const context = this.surface.clear();
    const names = this.layer.draw(context, camera, palette);
    if (this.fieldScale) drawField({ context, camera }, this.run, this.fieldScale, t);
    drawScene({ context, camera, palette, hatch, names }, this.run, t, chosen, afterglow);
  }

  /** The body or obstacle at a pixel, in lines of text; [] if there is none. */
  describe(px, py, t) {
    const [x, y] = this.camera.toFloor(px, py);
    const body = this.bodyAt(px, py, t);
    if (body) return wordsOfBody(body, t);
    const obstacle = this.layer.obstacleAt(x, y);
    if (!obstacle) return [];
    const place = `at (${fixed(x, 2)}, ${fixed(y, 2)})`;
    return [spoken(obstacle.name), `${obstacle.bottom} to ${obstacle.top} m high`, place];
  }

  /** The floor in words, for screen readers. */
  inWords(t) {
    return floorInWords(this.run, t);
  }

  /** The body at a pixel, or undefined. */
  bodyAt(px, py, t) {
    const [x, y] = this.camera.toFloor(px, py);
    return this.run.bodyAt(t, x, y, Math.max(0.5, 12 / this.camera.scale));
  }
}

/** A body's name, place and speed, in lines. */
function wordsOfBody(body, t) {
  const { x, y, speed } = body.motion.at(t);
  return [spoken(body.name), `(${fixed(x, 2)}, ${fixed(y, 2)}), ${fixed(speed, 2)} m/s`];
}

/** Who is where and does what. */
function floorInWords(run, t) {
  const bodies = [...run.bodies.values()].map(({ name, motion }) => {
    const { x, y, speed } = motion.at(t);
    const doing = speed > STILL ? `moving at ${speed.toFixed(1)} m/s` : "standing";
    return `${spoken(name)} ${doing} at ${x.toFixed(1)}, ${y.toFixed(1)}`;
  });
  return `The floor after ${t.toFixed(1)} seconds: ${bodies.join("; ")}.`;
}

/** Shows how long a number of metres is at so many CSS pixels a metre. */
function showScale(bar, scale) {
  const length = [0.5, 1, 2, 5, 10, 20, 50].find(m => m * scale >= 36) ?? 100;
  const width = `${Math.round(length * scale)}px`;
  if (bar.style.width !== width) bar.style.width = width;
  write(bar, `${length} m`);
}
