/* Obstacles in three dimensions: by their names, rectangles get the looks of tables, bins, belts and racks. */

const LOOKS_BY_NAME = [
  [/table|bench|desk/, tableParts],
  [/conveyor|belt/, beltParts],
  [/bin|box|crate|container/, binParts],
  [/rack|shel(f|ves)/, rackParts],
];
const RACK_LEVEL = 0.9;      // metres from one shelf of a rack to the next, at most
const STEEPEST = 1e-3;       // of a corner's cosine, up to which four corners are a rectangle

/** Puts an obstacle on a pile; `colors` are those of the theme, as light. */
function addObstacle(pile, renderer, obstacle, colors, material = "edged") {
  const { name, footprint, bottom, top } = obstacle;
  const height = Math.max(top - bottom, 0.01);
  const color = mixed(colors.low, colors.high, Math.min(1, top / TALLEST) ** 1.5 * 0.5);
  const box = rectangleOf(footprint, bottom);
  if (!box) {
    const shape = renderer.learned(obstacle, () => prismMesh(footprint, bottom, top));
    pile.add(shape, material === "edged" ? "solid" : material, frameAt(0, 0), color, material === "pane" ? 0.22 : 1);
    return;
  }
  const parts = bottom === 0 && material === "edged" && LOOKS_BY_NAME.find(([names]) => names.test(name))?.[1];
  const size = { ...box, height };
  if (!parts) {
    pile.add("box", material, sized(box.frame, box.length, box.width, height), color, material === "pane" ? 0.22 : 1);
    return;
  }
  /** A box in the frame of the obstacle: its middle, the height of its foot, its lengths. */
  const put = (x, y, z, length, width, high, own = color) => pile.add(
    "box", material, sized(shifted(box.frame, x, y, z), length, width, high), own);
  parts(put, size, colors, color);
}

/** {frame, length, width} of a ring that is a rectangle; its frame stands at `z` in its middle. */
function rectangleOf(ring, z) {
  if (ring.length !== 4) return null;
  const [a, b, c, d] = ring;
  const [length, width] = [Math.hypot(b[0] - a[0], b[1] - a[1]), Math.hypot(d[0] - a[0], d[1] - a[1])];
  const along = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
  const across = [(d[0] - a[0]) / width, (d[1] - a[1]) / width];
  const isSquare = Math.abs(along[0] * across[0] + along[1] * across[1]) < STEEPEST
    && Math.hypot(b[0] + d[0] - a[0] - c[0], b[1] + d[1] - a[1] - c[1]) < STEEPEST * (length + width);
  if (!isSquare) return null;
  return { frame: frameAt((a[0] + c[0]) / 2, (a[1] + c[1]) / 2, z, Math.atan2(along[1], along[0])), length, width };
}

function tableParts(put, { length, width, height }, colors) {
  const [leg, plate] = [0.07, Math.min(0.07, height / 4)];
  put(0, 0, height - plate, length, width, plate, mixed(colors.low, colors.wood, 0.55));
  for (const x of [-1, 1]) {
    for (const y of [-1, 1]) {
      put(x * (length / 2 - leg), y * (width / 2 - leg), 0, leg, leg, height - plate, colors.steel);
    }
  }
  put(0, 0, 0.22 * height, length - 2 * leg, width - 2 * leg, 0.03, colors.steel);
}

function binParts(put, { length, width, height }, colors) {
  const [wall, foot] = [0.03, 0.35 * height];
  const shell = mixed(colors.low, colors.bin, 0.6);
  for (const side of [-1, 1]) {
    put(side * (length - wall) / 2, 0, foot, wall, width, height - foot, shell);
    put(0, side * (width - wall) / 2, foot, length - 2 * wall, wall, height - foot, shell);
  }
  put(0, 0, foot, length - 2 * wall, width - 2 * wall, 0.25 * (height - foot), mixed(shell, colors.high, 0.35));
  for (const x of [-1, 1]) {
    for (const y of [-1, 1]) put(x * (length / 2 - 0.05), y * (width / 2 - 0.05), 0, 0.05, 0.05, foot, colors.steel);
  }
}

function beltParts(put, { length, width, height }, colors) {
  const isAlong = length >= width;
  const [long, wide] = isAlong ? [length, width] : [width, length];
  const turn = (along, across, z, l, w, h, color) => (isAlong
    ? put(along, across, z, l, w, h, color) : put(across, along, z, w, l, h, color));
  turn(0, 0, height - 0.12, long, wide - 0.1, 0.09, mixed(colors.high, colors.ink, 0.45));
  for (const side of [-1, 1]) turn(0, side * (wide / 2 - 0.025), height - 0.16, long, 0.05, 0.16, colors.steel);
  const pairs = Math.max(2, Math.round(long / 1.6));
  for (let i = 0; i < pairs; i++) {
    const place = -long / 2 + 0.15 + ((long - 0.3) * i) / (pairs - 1);
    for (const side of [-1, 1]) turn(place, side * (wide / 2 - 0.06), 0, 0.07, 0.07, height - 0.16, colors.steel);
  }
}

function rackParts(put, { length, width, height }, colors, color) {
  const levels = Math.max(1, Math.ceil(height / RACK_LEVEL));
  const post = Math.min(0.08, width / 4);
  for (const x of [-1, 1]) {
    for (const y of [-1, 1]) put(x * (length - post) / 2, y * (width - post) / 2, 0, post, post, height, colors.steel);
  }
  for (let level = 0; level < levels; level++) {
    const z = (height / levels) * level;
    put(0, 0, z + 0.08, length - post, width - post, 0.05, colors.steel);
    put(0, 0, z + 0.13, length - 3 * post, width - 2 * post, 0.6 * (height / levels), mixed(color, colors.wood, 0.5));
  }
}
