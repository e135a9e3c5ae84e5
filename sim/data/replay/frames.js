/* Frames and projections of the view in three dimensions: x east, y north, z up, metres. */

/**
 * A frame is where a thing stands and how it is turned and stretched: its x, y and z axis and its
 * origin, twelve numbers. This one stands upright at a place, turned about z (radians).
 */
function frameAt(x, y, z = 0, rotation = 0) {
  const c = Math.cos(rotation);
  const s = Math.sin(rotation);
  return [c, s, 0, -s, c, 0, 0, 0, 1, x, y, z];
}

/** The frame, moved along its own axes. */
function shifted(f, dx, dy, dz) {
  return [f[0], f[1], f[2], f[3], f[4], f[5], f[6], f[7], f[8],
    f[9] + dx * f[0] + dy * f[3] + dz * f[6],
    f[10] + dx * f[1] + dy * f[4] + dz * f[7],
    f[11] + dx * f[2] + dy * f[5] + dz * f[8]];
}

/** The frame, turned about its y axis: what hangs down from it swings forward. */
function swung(f, angle) {
  const c = Math.cos(angle);
  const s = Math.sin(angle);
  return [c * f[0] + s * f[6], c * f[1] + s * f[7], c * f[2] + s * f[8], f[3], f[4], f[5],
    c * f[6] - s * f[0], c * f[7] - s * f[1], c * f[8] - s * f[2], f[9], f[10], f[11]];
}

/** The frame, turned about its x axis: what stands on it leans to the right. */
function leaned(f, angle) {
  const c = Math.cos(angle);
  const s = Math.sin(angle);
  return [f[0], f[1], f[2], c * f[3] + s * f[6], c * f[4] + s * f[7], c * f[5] + s * f[8],
    c * f[6] - s * f[3], c * f[7] - s * f[4], c * f[8] - s * f[5], f[9], f[10], f[11]];
}

/** The frame, stretched along its axes. */
function sized(f, length, width, height) {
  return [f[0] * length, f[1] * length, f[2] * length, f[3] * width, f[4] * width, f[5] * width,
    f[6] * height, f[7] * height, f[8] * height, f[9], f[10], f[11]];
}

/** A flat strip from one place to another, `width` wide, at a height: for the unit square. */
function stripFrom([ax, ay], [bx, by], z, width) {
  const length = Math.hypot(bx - ax, by - ay);
  return sized(frameAt((ax + bx) / 2, (ay + by) / 2, z, Math.atan2(by - ay, bx - ax)), length, width, 1);
}

const difference = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = a => a.map(value => value / Math.hypot(...a));

/* Matrices are column by column, as WebGL takes them. */

/** From the world to what is seen from `eye` towards `target`: x right, y up, z towards the viewer. */
function viewMatrix(eye, target) {
  const back = unit(difference(eye, target));
  const right = unit(cross([0, 0, 1], back));
  const up = cross(back, right);
  return [right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0,
    -dot(right, eye), -dot(up, eye), -dot(back, eye), 1];
}

/** `field` is the vertical angle of view (radians), `aspect` the width of the picture by its height. */
function perspectiveMatrix(field, aspect, near, far) {
  const f = 1 / Math.tan(field / 2);
  return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1,
    0, 0, (2 * far * near) / (near - far), 0];
}

/** A box of `half` metres to each side, from `near` to `far` in front. */
function parallelMatrix(half, near, far) {
  return [1 / half, 0, 0, 0, 0, 1 / half, 0, 0, 0, 0, 2 / (near - far), 0, 0, 0, (far + near) / (near - far), 1];
}

function product(a, b) {
  const c = new Array(16);
  for (let column = 0; column < 4; column++) {
    for (let row = 0; row < 4; row++) {
      let sum = 0;
      for (let k = 0; k < 4; k++) sum += a[4 * k + row] * b[4 * column + k];
      c[4 * column + row] = sum;
    }
  }
  return c;
}

/** What a matrix makes of a point: [x, y, z, w]. */
function transformed(m, [x, y, z]) {
  return [0, 1, 2, 3].map(row => m[row] * x + m[4 + row] * y + m[8 + row] * z + m[12 + row]);
}
