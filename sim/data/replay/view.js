/* One run on a canvas: the floor, the bodies, and the gestures of mouse and fingers. */

const CLICK_TREMOR = 3;        // pixels that a pointer may move while it clicks
const FOLLOW_SCALE = 45;       // pixels a metre, at least, when a body is followed

/**
 * Shows a run. `on` has the actions when the user moves the floor by (dx, dy) pixels (`pan`), zooms by
 * a factor at a pixel (`zoom`), points somewhere (`point`) or clicks on a body (`pick`).
 */
class View {
  constructor(run, canvas, on, onResize) {
    this.canvas = canvas;
    this.on = on;
    this.followed = null;
    this.camera = new Camera(boxOf(run.plan.boundary));
    this.surface = new Surface(canvas, onResize);
    this.show(run);
    this.#wire();
  }

  /** Shows another run on the same floor. */
  show(run) {
    this.run = run;
    this.layer = new FloorLayer(run.plan);
  }

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
    drawScene({ context, camera, palette, hatch, names }, this.run, t, chosen, afterglow);
  }

  /** The body or obstacle at a pixel, in lines of text; [] if there is none. */
  describe(px, py, t) {
    const [x, y] = this.camera.toFloor(px, py);
    const body = this.#bodyAt(px, py, t);
    if (body) {
      const state = body.motion.at(t);
      const place = `(${fixed(state.x, 2)}, ${fixed(state.y, 2)})`;
      return [spoken(body.name), `${place}, ${fixed(state.speed, 2)} m/s`];
    }
    const obstacle = this.layer.obstacleAt(x, y);
    if (!obstacle) return [];
    const place = `at (${fixed(x, 2)}, ${fixed(y, 2)})`;
    return [spoken(obstacle.name), `${obstacle.bottom} to ${obstacle.top} m high`, place];
  }

  /** The floor in words, for screen readers. */
  inWords(t) {
    const bodies = [...this.run.bodies.values()].map(({ name, motion }) => {
      const { x, y, speed } = motion.at(t);
      const doing = speed > STILL ? `moving at ${speed.toFixed(1)} m/s` : "standing";
      return `${spoken(name)} ${doing} at ${x.toFixed(1)}, ${y.toFixed(1)}`;
    });
    return `The floor after ${t.toFixed(1)} seconds: ${bodies.join("; ")}.`;
  }

  #bodyAt(px, py, t) {
    const [x, y] = this.camera.toFloor(px, py);
    return this.run.bodyAt(t, x, y, Math.max(0.5, 12 / this.camera.scale));
  }

  #wire() {
    const { canvas, on } = this;
    const pointers = new Map();
    const place = event => [event.offsetX, event.offsetY];
    const spread = ([[ax, ay], [bx, by]]) => ({
      x: (ax + bx) / 2, y: (ay + by) / 2, width: Math.hypot(ax - bx, ay - by),
    });
    let way = 0;               // pixels that the pointers have moved since the first one came down

    canvas.addEventListener("pointerdown", event => {
      canvas.setPointerCapture(event.pointerId);
      if (pointers.size === 0) way = 0;
      pointers.set(event.pointerId, place(event));
    });
    canvas.addEventListener("pointermove", event => {
      if (!pointers.has(event.pointerId)) {
        on.point(this, event);
        return;
      }
      hideHint();
      const before = [...pointers.values()];
      pointers.set(event.pointerId, place(event));
      const after = [...pointers.values()];
      if (after.length === 1) {
        const [dx, dy] = [after[0][0] - before[0][0], after[0][1] - before[0][1]];
        way += Math.hypot(dx, dy);
        if (way > CLICK_TREMOR) on.pan(dx, dy);
      } else if (after.length === 2) {
        const [from, to] = [spread(before), spread(after)];
        way = Infinity;
        on.pan(to.x - from.x, to.y - from.y);
        if (from.width > 0) on.zoom(to.width / from.width, to.x, to.y);
      }
    });
    canvas.addEventListener("pointerup", event => {
      if (!pointers.delete(event.pointerId) || way > CLICK_TREMOR) return;
      on.pick(this, t => this.#bodyAt(...place(event), t));
    });
    canvas.addEventListener("pointercancel", event => pointers.delete(event.pointerId));
    canvas.addEventListener("pointerleave", hideHint);
    canvas.addEventListener("wheel", event => {
      event.preventDefault();
      on.zoom(zoomFactor(event), ...place(event));
    }, { passive: false });
  }
}

/** Shows how long a number of metres is at so many CSS pixels a metre. */
function showScale(bar, scale) {
  const length = [0.5, 1, 2, 5, 10, 20, 50].find(m => m * scale >= 48) ?? 100;
  const width = `${Math.round(length * scale)}px`;
  if (bar.style.width !== width) bar.style.width = width;
  write(bar, `${length} m`);
}

/** The factor by which a turn of the wheel zooms in (above 1) or out. */
function zoomFactor(event) {
  const pixels = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1);
  const rate = event.ctrlKey ? 0.01 : 0.0015;      // a pinch on a touchpad comes as ctrl and wheel
  return Math.exp(-pixels * rate);
}
