/* Mouse, fingers and wheel on a canvas. */

const CLICK_TREMOR = 3;        // pixels that a pointer may move while it clicks

/**
 * Wires a canvas. `on` has: `drag(dx, dy, event)` by pixels, `slide(dx, dy)` with two fingers, `zoom(factor, px, py)`,
 * `point(event)` without a button, and `click(px, py)`. Where `grab(px, py)` returns {move, end, cancel} for a
 * press, that is all that comes of it.
 */
function wireGestures(canvas, on) {
  const pointers = new Map();
  const place = event => [event.offsetX, event.offsetY];
  const spread = ([[ax, ay], [bx, by]]) => ({
    x: (ax + bx) / 2, y: (ay + by) / 2, width: Math.hypot(ax - bx, ay - by),
  });
  let grabbed = null;        // what the press under way is grabbed by
  let way = 0;               // pixels that the pointers have moved since the first one came down

  canvas.addEventListener("pointerdown", event => {
    canvas.setPointerCapture(event.pointerId);
    if (pointers.size === 0) {
      way = 0;
      grabbed = on.grab(...place(event));
    }
    pointers.set(event.pointerId, place(event));
  });
  canvas.addEventListener("pointermove", event => {
    if (!pointers.has(event.pointerId)) {
      on.point(event);
      return;
    }
    hideHint();
    if (grabbed) {
      grabbed.move(...place(event));
      return;
    }
    const before = [...pointers.values()];
    pointers.set(event.pointerId, place(event));
    const after = [...pointers.values()];
    if (after.length === 1) {
      const [dx, dy] = [after[0][0] - before[0][0], after[0][1] - before[0][1]];
      way += Math.hypot(dx, dy);
      if (way > CLICK_TREMOR) on.drag(dx, dy, event);
    } else if (after.length === 2) {
      const [from, to] = [spread(before), spread(after)];
      way = Infinity;
      on.slide(to.x - from.x, to.y - from.y);
      if (from.width > 0) on.zoom(to.width / from.width, to.x, to.y);
    }
  });
  canvas.addEventListener("pointerup", event => {
    const isEnd = pointers.delete(event.pointerId) && pointers.size === 0;
    if (grabbed && isEnd) {
      grabbed.end();
      grabbed = null;
      return;
    }
    if (grabbed || way > CLICK_TREMOR) return;
    on.click(...place(event));
  });
  canvas.addEventListener("pointercancel", event => {
    pointers.delete(event.pointerId);
    grabbed?.cancel();
    grabbed = null;
  });
  canvas.addEventListener("pointerleave", hideHint);
  canvas.addEventListener("contextmenu", event => {
    if (way > CLICK_TREMOR) event.preventDefault();
  });
  canvas.addEventListener("wheel", event => {
    event.preventDefault();
    on.zoom(zoomFactor(event), ...place(event));
  }, { passive: false });
}

/** The factor by which a turn of the wheel zooms in (above 1) or out. */
function zoomFactor(event) {
  const pixels = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1);
  const rate = event.ctrlKey ? 0.01 : 0.0015;      // a pinch on a touchpad comes as ctrl and wheel
  return Math.exp(-pixels * rate);
}
