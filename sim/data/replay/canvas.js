/* A sharp canvas, colours, text, glyphs. */

const FONT = 'system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", sans-serif';

const COLORS = [
  "page", "floor", "line", "grid", "text", "muted", "low", "high", "edge", "halo", "card",
  "person-1", "person-2", "person-3", "person-4", "robot", "robot-ink", "vehicle", "notice",
  "danger", "danger-ink",
];

/** The colours of the style sheet by name, as they are in the present theme. */
function readPalette() {
  const style = getComputedStyle(document.documentElement);
  return Object.fromEntries(COLORS.map(name => [name, style.getPropertyValue(`--${name}`).trim()]));
}

/**
 * A canvas that has as many pixels as the screen shows of it; units are CSS pixels. `onResize` is
 * called before the browser paints a new size, for which all has to be redrawn.
 */
class Surface {
  constructor(canvas, onResize) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.width = this.height = this.ratio = 1;
    const box = "devicePixelContentBoxSize" in ResizeObserverEntry.prototype
      ? "device-pixel-content-box" : "content-box";
    new ResizeObserver(() => { if (!this.#isFit()) onResize(); }).observe(canvas, { box });
    this.fit();
  }

  /** Takes the size that the canvas has on the page, which empties it. */
  fit() {
    if (this.#isFit()) return;
    const { width, height, ratio } = this.#shown();
    Object.assign(this, { width, height, ratio });
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
  }

  #isFit() {
    const { width, height, ratio } = this.#shown();
    return width === this.width && height === this.height && ratio === this.ratio;
  }

  #shown() {
    const { clientWidth, clientHeight } = this.canvas;
    return {
      width: Math.max(1, clientWidth), height: Math.max(1, clientHeight), ratio: window.devicePixelRatio || 1,
    };
  }

  /** A clean context in CSS pixels. */
  clear() {
    this.context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    this.context.clearRect(0, 0, this.width, this.height);
    return this.context;
  }
}

/** Text with a halo, readable on any ground. */
function drawText(context, text, x, y, { color, halo, size = 11, weight = 400, align = "center" }) {
  context.font = `${weight} ${size}px ${FONT}`;
  context.textAlign = align;
  context.textBaseline = "middle";
  if (halo) {
    context.lineJoin = "round";
    context.lineWidth = 3;
    context.strokeStyle = halo;
    context.strokeText(text, x, y);
  }
  context.fillStyle = color;
  context.fillText(text, x, y);
}

/** Text on a small plate of its own, for figures that must not be misread. */
function drawPlate(context, text, x, y, palette, color) {
  const width = plateWidth(context, text);
  context.beginPath();
  context.roundRect(x - width / 2, y - 10, width, 20, 5);
  context.fillStyle = palette.card;
  context.strokeStyle = palette[color];
  context.lineWidth = 1;
  context.fill();
  alpha(context, 0.5, () => context.stroke());
  drawText(context, text, x, y + 0.5, { color: palette[color], size: 12, weight: 600 });
}

const plateWidth = (context, text) => textWidth(context, text, { size: 12, weight: 600 }) + 12;

const WIDTHS = new Map();    // pixels of texts that were measured
const MOST_WIDTHS = 2000;

function textWidth(context, text, { size, weight }) {
  const key = `${weight} ${size} ${text}`;
  let wide = WIDTHS.get(key);
  if (wide === undefined) {
    context.font = `${weight} ${size}px ${FONT}`;
    wide = context.measureText(text).width;
    if (WIDTHS.size >= MOST_WIDTHS) WIDTHS.clear();
    WIDTHS.set(key, wide);
  }
  return wide;
}

const GLYPHS = {};           // the paths of shapes that were drawn

/** An event's shape in the middle of (x, y); `size` 1 is 12 pixels wide. */
function drawGlyph(context, { shape, hollow, color }, x, y, palette, size = 1) {
  const path = GLYPHS[shape] ??= new Path2D(SHAPES[shape]);
  context.save();
  context.translate(x, y);
  context.scale(size, size);
  if (hollow || LINES.includes(shape)) {
    context.lineWidth = hollow ? THIN : BOLD;
    context.strokeStyle = palette[color];
    context.stroke(path);
  } else {
    context.lineWidth = 2;
    context.strokeStyle = palette.halo;
    context.stroke(path);
    context.fillStyle = palette[color];
    context.fill(path);
  }
  context.restore();
}

/** A pattern of slanted lines, which says "not allowed" without a hue. */
function hatching(context, color, ratio) {
  const size = Math.round(6 * ratio);
  const tile = document.createElement("canvas");
  tile.width = tile.height = size;
  const pen = tile.getContext("2d");
  pen.strokeStyle = color;
  pen.lineWidth = ratio;
  pen.beginPath();
  for (const shift of [-size, 0, size]) {
    pen.moveTo(shift, size);
    pen.lineTo(shift + size, 0);
  }
  pen.stroke();
  const pattern = context.createPattern(tile, "repeat");
  pattern.setTransform(new DOMMatrix().scale(1 / ratio));
  return pattern;
}

function alpha(context, opacity, draw) {
  context.save();
  context.globalAlpha *= opacity;
  draw();
  context.restore();
}
