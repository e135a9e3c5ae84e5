/* Lines of sight: where a straight line first meets an upright solid. */

/** An upright solid: its footprint as a ring of points, from one height to another, with the box round it. */
function uprightSolid(footprint, bottom, top) {
  return { footprint, bottom, top, box: boxOf(footprint) };
}

/** The share of the line from one point to another at which it enters a solid; Infinity if it does not. */
function entryInto({ footprint, bottom, top, box }, from, to) {
  const isBeside = (axis, low, high) => (
    (from[axis] < low && to[axis] < low) || (from[axis] > high && to[axis] > high));
  if (isBeside(2, bottom, top) || isBeside(0, box.left, box.right) || isBeside(1, box.bottom, box.top)) return Infinity;
  let [begin, end] = [0, 1];
  for (const [axis, low, high] of [[2, bottom, top], [0, box.left, box.right], [1, box.bottom, box.top]]) {
    const change = to[axis] - from[axis];
    if (Math.abs(change) < 1e-12) {
      if (from[axis] < low || from[axis] > high) return Infinity;
      continue;
    }
    const [a, b] = [(low - from[axis]) / change, (high - from[axis]) / change];
    begin = Math.max(begin, Math.min(a, b));
    end = Math.min(end, Math.max(a, b));
    if (begin > end) return Infinity;
  }
  const at = share => [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])];
  if (isInside(footprint, ...at(begin + 1e-9))) return begin;
  let first = Infinity;
  footprint.forEach((a, i) => {
    const share = crossingOf(from, to, a, footprint[(i + 1) % footprint.length]);
    if (share >= begin && share <= end) first = Math.min(first, share);
  });
  return first;
}

/** The share of the line `from`–`to` at which it crosses the edge a–b on the floor, or NaN. */
function crossingOf([x0, y0], [x1, y1], [ax, ay], [bx, by]) {
  const [dx, dy, ex, ey] = [x1 - x0, y1 - y0, bx - ax, by - ay];
  const turn = dx * ey - dy * ex;
  const along = ((ax - x0) * ey - (ay - y0) * ex) / turn;
  const across = ((ax - x0) * dy - (ay - y0) * dx) / turn;
  return across >= 0 && across <= 1 ? along : NaN;
}

/** A body at t as an upright solid, a little larger than it is, for pointing at it. */
function solidOfBody(body, t) {
  const { x, y, rotation } = body.motion.at(t);
  const isPerson = body.category === "person";
  const [length, width] = isPerson ? [0.7, 0.7] : [body.length, body.width];
  const frame = frameAt(x, y, 0, rotation);
  const ring = [[1, 1], [-1, 1], [-1, -1], [1, -1]]
    .map(([a, b]) => shifted(frame, (a * length) / 2, (b * width) / 2, 0).slice(9, 11));
  return uprightSolid(ring, bottomOf(body), heightOf(body));
}

/** The height of a body's foot and of its top, metres; of an old recording as high as such bodies are. */
const bottomOf = body => body.bottom ?? (body.bridge ? 1.24 : 0);
const heightOf = body => body.top ?? body.height ?? { person: TALL, robot: body.bridge ? 2.71 : 1.6, vehicle: 1 }[body.category];
