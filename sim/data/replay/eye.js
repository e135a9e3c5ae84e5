/* The camera of the view in three dimensions: round the floor, after a body, or a person's own eyes. */

const FIELD = 0.62;          // radians of the view from outside, from top to bottom
const FIELD_OF_EYES = 1.15;  // of a person's own
const STEEPEST_LOOK = 1.5;   // radians above the horizon
const NEAREST_LOOK = 2;      // metres from what is looked at
const TURN = 0.006;          // radians a pixel
const ASIDE = 0.22;           // radians by which the first look is aside
const LOW_LOOK = 0.06;       // radians above the horizon, at least, from outside

class Eye {
  /** `bounds` is the box of the floor; all `points` are on the screen when the whole floor is shown. */
  constructor(bounds, points) {
    this.bounds = bounds;
    this.points = points;
    this.width = this.height = 1;
    this.isFitted = true;
    this.inside = null;        // {x, y, z, heading} of the eyes looked through
    this.turned = this.raised = 0;        // by which their look is turned from straight on
    this.fit();
  }

  resize({ width, height }) {
    const isNew = width !== this.width || height !== this.height;
    Object.assign(this, { width, height });
    if (this.isFitted && isNew) this.fit();
    this.#look();
  }

  get screen() {
    return { left: 0, right: this.width, top: 0, bottom: this.height };
  }

  /** CSS pixels a metre where it looks. */
  get scale() {
    return this.height / (2 * this.distance * Math.tan(FIELD / 2));
  }

  /** Shows the whole floor, its longer side across the longer side of the screen. */
  fit() {
    const { left, right, bottom, top } = this.bounds;
    const isTurned = (right - left > top - bottom) !== (this.width > this.height)
      && Math.max(right - left, top - bottom) > 1.3 * Math.min(right - left, top - bottom);
    this.azimuth = (isTurned ? Math.PI : -Math.PI / 2) + ASIDE;
    this.elevation = 0.66 + 0.5 * Math.min(Math.max(1.3 - this.width / this.height, 0), 0.7);
    this.target = [(left + right) / 2, (bottom + top) / 2, 0];
    this.turned = this.raised = 0;
    const farthest = 8 * Math.hypot(right - left, top - bottom) + 10;
    const fits = distance => {
      this.distance = distance;
      this.#look();
      const seen = this.points.map(point => this.#onScreen(point));
      if (seen.some(place => !place)) return false;
      const [xs, ys] = [0, 1].map(axis => seen.map(place => place[axis]));
      return Math.max(...xs) - Math.min(...xs) < 0.95 * this.width
        && Math.max(...ys) - Math.min(...ys) < 0.9 * this.height;
    };
    for (let round = 0; round < 3; round++) {
      let [near, far] = [NEAREST_LOOK, farthest];
      for (let i = 0; i < 24; i++) {
        const middle = (near + far) / 2;
        if (fits(middle)) far = middle;
        else near = middle;
      }
      this.fitted = far;
      fits(far);
      if (round < 2) this.#centre(this.points);
    }
    this.isFitted = true;
  }

  /** Moves what it looks at, so that the points are in the middle of the screen. */
  #centre(points) {
    const ends = axis => {
      const seen = points.map(point => this.#onScreen(point)[axis]);
      return (Math.min(...seen) + Math.max(...seen)) / 2;
    };
    this.pan(this.width / 2 - ends(0), 0.52 * this.height - ends(1));
  }

  /** Zoom so that what is under (px, py) stays there. */
  zoom(factor, px = this.width / 2, py = this.height / 2) {
    const before = this.distance;
    this.distance = Math.min(Math.max(before / factor, NEAREST_LOOK), 4 * this.fitted);
    const place = this.onFloor(px, py);
    const share = 1 - this.distance / before;
    if (place && Math.abs(share) < 1) this.lookAt(...[0, 1].map(i => this.target[i] + share * (place[i] - this.target[i])));
    this.#look();
  }

  /** Moves what is seen by so many pixels. */
  pan(dx, dy) {
    const [c, s] = [Math.cos(this.azimuth), Math.sin(this.azimuth)];
    const across = dx / this.scale;
    const along = dy / this.scale / Math.max(0.35, Math.sin(this.elevation));
    this.lookAt(this.target[0] + s * across - c * along, this.target[1] - c * across - s * along);
    this.#look();
  }

  /** Goes round what it looks at, or turns the look of the eyes that it is in. */
  orbit(dx, dy) {
    if (this.inside) {
      this.turned += dx * TURN / 2;
      this.raised = Math.min(Math.max(this.raised + dy * TURN / 2, -1.2), 1.2);
    } else {
      this.azimuth -= dx * TURN;
      this.elevation = Math.min(Math.max(this.elevation + dy * TURN, LOW_LOOK), STEEPEST_LOOK);
      this.isFitted = false;
    }
    this.#look();
  }

  lookAt(x, y, z = 0) {
    const { left, right, bottom, top } = this.bounds;
    const border = Math.max(right - left, top - bottom) / 2;
    this.target = [Math.min(Math.max(x, left - border), right + border),
      Math.min(Math.max(y, bottom - border), top + border), z];
    this.isFitted = false;
    this.#look();
  }

  /** Looks through eyes at {x, y, z, heading}, or (null) from outside again. */
  lookThrough(eyes) {
    if (!eyes) this.turned = this.raised = 0;
    this.inside = eyes;
    this.#look();
  }

  /** The place of a point on the screen in CSS pixels, and its distance: [px, py, metres]; null if it is behind. */
  toScreen(x, y, z) {
    return this.#onScreen([x, y, z]);
  }

  /** The place of the floor under a pixel, [x, y]; null above the horizon. */
  onFloor(px, py) {
    const ray = this.ray(px, py);
    if (ray[2] > -1e-4) return null;
    const far = -this.position[2] / ray[2];
    return [this.position[0] + far * ray[0], this.position[1] + far * ray[1]];
  }

  /** The direction from the eye through a pixel. */
  ray(px, py) {
    const [side, up, back] = [0, 1, 2].map(row => [0, 1, 2].map(column => this.view[4 * column + row]));
    const high = Math.tan(this.field / 2);
    const x = ((2 * px) / this.width - 1) * high * (this.width / this.height);
    const y = (1 - (2 * py) / this.height) * high;
    return unit([0, 1, 2].map(i => x * side[i] + y * up[i] - back[i]));
  }

  #onScreen(point) {
    const [x, y, , w] = transformed(this.matrix, point);
    return w > 0.05 ? [(x / w + 1) * this.width / 2, (1 - y / w) * this.height / 2, w] : null;
  }

  #look() {
    const { inside } = this;
    this.field = inside ? FIELD_OF_EYES : FIELD;
    if (inside) {
      const heading = inside.heading + this.turned;
      const raised = this.raised - 0.12;      // people look at where they are about to tread
      this.position = [inside.x, inside.y, inside.z];
      this.looked = [inside.x + Math.cos(heading) * Math.cos(raised),
        inside.y + Math.sin(heading) * Math.cos(raised), inside.z + Math.sin(raised)];
    } else {
      const { azimuth, elevation, distance, target } = this;
      this.position = [target[0] + distance * Math.cos(elevation) * Math.cos(azimuth),
        target[1] + distance * Math.cos(elevation) * Math.sin(azimuth), target[2] + distance * Math.sin(elevation)];
      this.looked = target;
    }
    const far = (this.distance ?? 1) + 4 * Math.hypot(this.bounds.right - this.bounds.left, this.bounds.top - this.bounds.bottom);
    const near = inside ? 0.08 : Math.max(0.1, this.distance / 50);
    this.view = viewMatrix(this.position, this.looked);
    this.matrix = product(perspectiveMatrix(this.field, this.width / this.height, near, far), this.view);
  }
}
