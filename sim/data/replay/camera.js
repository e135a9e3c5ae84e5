/* The part of the floor that is seen, and its scale. */

/** The part of the floor that is seen: its centre in metres, the scale in CSS pixels a metre. */
class Camera {
  constructor(bounds) {
    this.bounds = bounds;
    this.width = this.height = this.ratio = 1;
    this.isFitted = true;
    this.fit();
  }

  resize({ width, height, ratio }) {
    Object.assign(this, { width, height, ratio });
    if (this.isFitted) this.fit();
  }

  /** Show the whole floor. */
  fit() {
    const { left, right, bottom, top } = this.bounds;
    const border = Math.min(10, this.width / 20);
    this.x = (left + right) / 2;
    this.y = (bottom + top) / 2;
    this.scale = Math.max(1, Math.min(
      (this.width - 2 * border) / (right - left), (this.height - 2 * border) / (top - bottom)));
    this.fitted = this.scale;
    this.isFitted = true;
  }

  /** The screen as a box in pixels. */
  get screen() {
    return { left: 0, right: this.width, top: 0, bottom: this.height };
  }

  toScreen(x, y) {
    return [this.width / 2 + (x - this.x) * this.scale, this.height / 2 - (y - this.y) * this.scale];
  }

  toFloor(px, py) {
    return [this.x + (px - this.width / 2) / this.scale, this.y - (py - this.height / 2) / this.scale];
  }

  /** The place of the floor under a pixel, [x, y]. */
  onFloor(px, py) { return this.toFloor(px, py); }

  pan(dx, dy) {
    this.lookAt(this.x - dx / this.scale, this.y + dy / this.scale);
  }

  lookAt(x, y) {
    this.x = x;
    this.y = y;
    this.isFitted = false;
  }

  /** Zoom so that what is under (px, py) stays there. */
  zoom(factor, px = this.width / 2, py = this.height / 2) {
    const [x, y] = this.toFloor(px, py);
    this.scale = Math.min(Math.max(this.scale * factor, this.fitted / 3), 400);
    const [nx, ny] = this.toFloor(px, py);
    this.lookAt(this.x + x - nx, this.y + y - ny);
  }
}
