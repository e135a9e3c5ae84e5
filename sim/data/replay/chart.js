/* The plot and the timeline below it. */

const ROW_HEIGHT = 17;
const AXIS_HEIGHT = 16;
const GUTTER = { left: 52, right: 12, top: 6 };

/** Distance and required distance over the whole run, and below them the events: one time axis. */
class Chart {
  constructor(element, recording, bodies, disabled, onResize) {
    this.duration = recording.duration;
    this.summary = recording.summary ?? {};
    this.disabled = disabled;
    this.marks = recording.events.map(event => ({ event, look: lookOf(event, bodies) }))
      .filter(mark => mark.look.row)
      .sort((a, b) => (a.event.kind === "violation") - (b.event.kind === "violation"));   // on top
    this.cursor = element.querySelector("#cursor");
    this.surface = new Surface(element.querySelector("canvas"), onResize);
  }

  toX(t) {
    return GUTTER.left + (t / this.duration) * (this.surface.width - GUTTER.left - GUTTER.right);
  }

  toTime(x) {
    const t = ((x - GUTTER.left) / (this.surface.width - GUTTER.left - GUTTER.right)) * this.duration;
    return Math.min(Math.max(t, 0), this.duration);
  }

  /** The mark within a few pixels of (x, y), the nearest first. */
  markAt(x, y) {
    const off = mark => Math.hypot(this.toX(mark.event.t) - x, this.#rowY(mark.look.row) - y);
    const near = this.marks.filter(mark => off(mark) <= 9);
    return near.sort((a, b) => off(a) - off(b))[0];
  }

  moveCursor(t) {
    this.cursor.style.transform = `translateX(${this.toX(t)}px)`;
  }

  get #plotBottom() {
    return this.surface.height - AXIS_HEIGHT - ROWS.length * ROW_HEIGHT - 4;
  }

  #rowY(row) {
    return this.#plotBottom + 4 + (ROWS.indexOf(row) + 0.5) * ROW_HEIGHT;
  }

  draw(watch, palette) {
    const context = this.surface.clear();
    this.#drawAxis(context, palette);
    if (watch) this.#drawPlot(context, watch, palette);
    this.#drawRows(context, watch, palette);
  }

  #drawAxis(context, palette) {
    const { width, height } = this.surface;
    const step = [1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200]
      .find(s => (s / this.duration) * (width - 70) >= 62) ?? this.duration;
    for (let t = 0; t <= this.duration + 1e-9; t += step) {
      const isOuter = t === 0 || t + step > this.duration;
      const x = Math.min(this.toX(t), width - 16);
      const y = height - AXIS_HEIGHT / 2 + 2;
      drawText(context, isOuter ? `${t} s` : `${t}`, x, y, { color: palette.muted });
      context.fillStyle = palette.grid;
      context.fillRect(Math.round(this.toX(t)), GUTTER.top, 1, height - AXIS_HEIGHT - GUTTER.top);
    }
  }

  #drawPlot(context, watch, palette) {
    const { width } = this.surface;
    const bottom = this.#plotBottom;
    const curves = watch.curves;
    const highest = this.#highest(curves);
    const toY = value => bottom - (value / highest) * (bottom - GUTTER.top);

    context.strokeStyle = palette.line;
    context.lineWidth = 1;
    const step = [0.5, 1, 2, 5, 10, 20, 50].find(s => (s / highest) * (bottom - GUTTER.top) >= 22) ?? 100;
    for (let value = 0; value <= highest; value += step) {
      const y = Math.round(toY(value)) + 0.5;
      context.beginPath();
      context.moveTo(GUTTER.left, y);
      context.lineTo(width - GUTTER.right, y);
      context.globalAlpha = value ? 0.5 : 1;
      context.stroke();
      context.globalAlpha = 1;
      drawText(context, value + step > highest ? `${value} m` : `${value}`, GUTTER.left - 7, y,
        { color: palette.muted, size: 11, align: "right" });
    }

    context.save();
    context.beginPath();
    context.rect(GUTTER.left, GUTTER.top, width - GUTTER.left - GUTTER.right, bottom - GUTTER.top + 1);
    context.clip();
    const line = (curve, field) => {
      const path = new Path2D();
      for (const point of curve) if (point[field] !== null) path.lineTo(this.toX(point.t), toY(point[field]));
      return path;
    };
    const region = (curve, field, edge) => {
      const path = line(curve, field);
      path.lineTo(this.toX(curve.at(-1).t), edge);
      path.lineTo(this.toX(curve[0].t), edge);
      path.closePath();
      return path;
    };
    const between = (curve, under, above, color, opacity) => {
      context.save();
      context.clip(region(curve, under, bottom));
      context.fillStyle = color;
      context.globalAlpha = opacity;
      context.fill(region(curve, above, -bottom));
      context.restore();
    };
    for (const curve of curves) {
      between(curve, "distance", "required", palette[watch.person.color], 0.1);    // the margin
      between(curve, "required", "distance", palette.danger, 0.35);                // what is missing
    }
    this.#drawViolationBands(context, watch, palette, GUTTER.top, bottom - GUTTER.top);
    context.lineJoin = "round";
    for (const curve of curves) {
      context.strokeStyle = palette.muted;
      context.lineWidth = 1;
      context.setLineDash([1, 3]);
      context.stroke(line(curve, "notice"));
      context.strokeStyle = palette.danger;
      context.lineWidth = 1.25;
      context.setLineDash([5, 3]);
      context.stroke(line(curve, "required"));
      context.strokeStyle = palette[watch.person.color];
      context.lineWidth = 1.75;
      context.setLineDash([]);
      context.stroke(line(curve, "distance"));
    }
    context.restore();
    const closest = this.#closest(watch);
    if (!closest) return;
    context.beginPath();
    context.arc(this.toX(closest.time), toY(closest.distance), 3.5, 0, 2 * Math.PI);
    context.fillStyle = palette.card;
    context.strokeStyle = palette[watch.person.color];
    context.lineWidth = 1.75;
    context.fill();
    context.stroke();
  }

  /** The minimum separation of the summary, where it is that of this watch. */
  #closest(watch) {
    const { minimum_separation: ofAll, people } = this.summary;
    const found = people?.[watch.person.name]?.minimum_separation ?? ofAll;
    if (!found || watch.other.kind !== "gantry") return null;
    const fits = state => Math.abs(state.distance - found.distance) < 1e-3;
    return fits(watch.at(found.time)) || fits(watch.before(found.time)) ? found : null;
  }

  /** The top of the plot: all that matters beside the required distance; what is farther may leave it. */
  #highest(curves) {
    let distance = 0;
    let required = 0;
    for (const curve of curves) {
      for (const point of curve) {
        distance = Math.max(distance, point.distance);
        required = Math.max(required, point.required);
      }
    }
    return Math.max(1, Math.min(distance * 1.05, required * 3));
  }

  #drawViolationBands(context, watch, palette, top, height) {
    const hatch = hatching(context, palette.danger, this.surface.ratio);
    for (const [begin, end] of watch.violations) {
      const x = this.toX(begin);
      const width = Math.max(2, this.toX(end) - x);
      context.fillStyle = palette.danger;
      alpha(context, 0.16, () => context.fillRect(x, top, width, height));
      context.fillStyle = hatch;
      alpha(context, 0.5, () => context.fillRect(x, top, width, height));
    }
  }

  #drawRows(context, watch, palette) {
    const { width } = this.surface;
    for (const row of ROWS) {
      const y = this.#rowY(row);
      drawText(context, row, GUTTER.left - 7, y, { color: palette.muted, size: 11, align: "right" });
      context.fillStyle = palette.line;
      context.fillRect(GUTTER.left, Math.round(y), width - GUTTER.left - GUTTER.right, 1);
    }
    const y = this.#rowY("safety") - 4;
    context.fillStyle = palette.gantry;
    for (const [begin, end] of this.disabled) {
      const wide = Math.max(2, this.toX(end) - this.toX(begin));
      alpha(context, 0.4, () => context.fillRect(this.toX(begin), y, wide, 8));
    }
    if (watch) this.#drawViolationBands(context, watch, palette, y, 8);
    for (const { event, look } of this.marks) {
      drawGlyph(context, look, this.toX(event.t), this.#rowY(look.row), palette, 0.8);
    }
  }
}
