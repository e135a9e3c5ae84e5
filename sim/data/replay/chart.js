/* The plot and the timeline below it: a band for each run, and one time axis for all. */

const ROW_HEIGHT = 17;
const AXIS_HEIGHT = 16;
const SOCIAL = 4;            // metres of two people that are shown: E. T. Hall's social distance, 3.7 m, and a little more
const GUTTER = { left: 52, right: 12, top: 6 };
const COLUMN = 3;            // pixels of a column where curves or marks are too dense
const DENSEST = 1.5;         // pixels for a mark, at least, of all rows; with less they are counted
const SAME = 1e-3;           // metres between equal separations
const SHORTEST = 2;          // seconds that the chart shows, at least

/** Distance, required distance and events over time, all of it or a part. */
class Chart {
  constructor(element, onResize) {
    this.cursor = element.querySelector("#cursor");
    this.surface = new Surface(element.querySelector("canvas"), onResize);
    this.bands = [];
    this.duration = this.from = this.to = 0;
  }

  show(runs) {
    const isWhole = this.from === 0 && this.to === this.duration;
    this.duration = Math.max(...runs.map(run => run.duration));
    if (isWhole || this.to > this.duration) this.showAll();
    this.bands = runs.map((run, i) => new Band(run, runs.length > 1 ? LETTERS[i] : ""));
  }

  toX(t) {
    return GUTTER.left + ((t - this.from) / (this.to - this.from)) * this.#width;
  }

  toTime(x) {
    const t = this.from + ((x - GUTTER.left) / this.#width) * (this.to - this.from);
    return Math.min(Math.max(t, 0), this.duration);
  }

  get #width() {
    return this.surface.width - GUTTER.left - GUTTER.right;
  }

  showAll() {
    this.#showFrom(0, this.duration);
  }

  /** Shows fewer seconds (`factor` above 1) or more; the instant at x stays there. */
  zoom(factor, x) {
    const t = this.toTime(x);
    const span = Math.min(Math.max((this.to - this.from) / factor, SHORTEST), this.duration);
    this.#showFrom(t - ((t - this.from) / (this.to - this.from)) * span, span);
  }

  /** Moves to earlier or later times by so many pixels. */
  shift(pixels) {
    const span = this.to - this.from;
    this.#showFrom(this.from + (pixels / this.#width) * span, span);
  }

  /** Moves to t if that is out of view; returns true if it was. */
  keepInView(t) {
    if (t >= this.from && t <= this.to) return false;
    const span = this.to - this.from;
    this.#showFrom(t - span / 10, span);
    return true;
  }

  #showFrom(t, span) {
    this.from = Math.min(Math.max(t, 0), this.duration - span);
    this.to = this.from + span;
  }

  /** The mark within a few pixels of (x, y), the nearest first. */
  markAt(x, y) {
    const marks = this.bands.filter(band => !band.isDense).flatMap(band => band.marks.map(mark => ({
      ...mark, off: Math.hypot(this.toX(mark.event.t) - x, band.rowY(mark.look.row) - y),
    })));
    return marks.filter(mark => mark.off <= 9).sort((a, b) => a.off - b.off)[0];
  }

  moveCursor(t) {
    this.cursor.hidden = t < this.from || t > this.to;
    this.cursor.style.transform = `translateX(${this.toX(t)}px)`;
  }

  /** Redraws the whole chart; `watches` has the chosen one of each run. */
  draw(watches, palette) {
    this.surface.fit();
    const context = this.surface.clear();
    if (this.#width < 1) return;             // the page is hidden, or narrower than the axis
    const height = (this.surface.height - AXIS_HEIGHT) / this.bands.length;
    const highest = Math.max(1, ...watches.filter(Boolean).map(highestOf));
    this.#drawAxis(context, palette);
    this.bands.forEach((band, i) => {
      band.place(i * height, height);
      const { from, to, surface } = this;
      const pen = { context, palette, from, to, toX: t => this.toX(t), surface };
      band.draw(pen, watches[i], pairOf(watches[i], watches[0]), highest);
    });
  }

  #drawAxis(context, palette) {
    const { width, height } = this.surface;
    const span = this.to - this.from;
    const step = [0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 14400, 43200, 86400]
      .find(s => (s / span) * (width - 70) >= 62) ?? span;
    const first = Math.ceil(this.from / step - 1e-9);
    for (let k = first; k * step <= this.to + 1e-9; k++) {
      const t = +(k * step).toFixed(3);
      const isOuter = k === first || (k + 1) * step > this.to;
      const x = Math.min(this.toX(t), width - 16);
      const y = height - AXIS_HEIGHT / 2 + 2;
      const words = this.to <= LONG ? `${t}${isOuter ? " s" : ""}` : dialTime(t, step);
      drawText(context, words, x, y, { color: palette.muted });
      context.fillStyle = palette.grid;
      context.fillRect(Math.round(this.toX(t)), GUTTER.top, 1, height - AXIS_HEIGHT - GUTTER.top);
    }
  }
}

/** A time of the axis of a long run, in h:mm where the step is of whole minutes, and else in h:mm:ss. */
function dialTime(t, step) {
  const digits = value => String(value).padStart(2, "0");
  const [h, m, s] = [Math.floor(t / 3600), Math.floor((t % 3600) / 60), +(t % 60).toFixed(1)];
  return step % 60 === 0 ? `${h}:${digits(m)}` : `${h}:${digits(m)}:${digits(s)}`;
}

/** One run's part of the chart: its plot, and below it a row for each kind of mark. */
class Band {
  constructor(run, letter) {
    this.run = run;
    this.letter = letter;
    this.marks = run.events.map(event => ({ event, look: lookOf(event, run.bodies) }))
      .filter(mark => mark.look.row)
      .sort((a, b) => (a.event.kind === "violation") - (b.event.kind === "violation"));   // on top
    this.place(0, 1);
  }

  /** Takes its place in the chart, pixels. */
  place(top, height) {
    this.top = top + GUTTER.top;
    this.bottom = top + height - ROWS.length * ROW_HEIGHT - 4;
  }

  rowY(row) {
    return this.bottom + 4 + (ROWS.indexOf(row) + 0.5) * ROW_HEIGHT;
  }

  draw(pen, watch, pair, highest) {
    const seen = this.marks.filter(({ event }) => event.t >= pen.from && event.t <= pen.to).length;
    this.isDense = seen * DENSEST > pen.surface.width;
    if (watch) this.#drawPlot(pen, watch, highest);
    else if (!this.run.watches.length) this.#drawSpeeds(pen);
    this.#drawRows(pen, watch);
    const { context, palette } = pen;
    if (!this.letter) return;
    const words = [this.letter, pair].filter(Boolean).join(" ");
    const middle = GUTTER.left + 4 + plateWidth(context, words) / 2;
    drawPlate(context, words, middle, this.top + 11, palette, "text");
  }

  #drawPlot(pen, watch, highest) {
    const { context, palette, toX, surface } = pen;
    const toY = value => this.bottom - (value / highest) * (this.bottom - this.top);
    this.#drawScale(pen, toY, highest);
    const line = (curve, field) => {
      const path = new Path2D();
      for (const point of curve) if (point[field] !== null) path.lineTo(toX(point.t), toY(point[field]));
      return path;
    };
    const wide = surface.width - GUTTER.left - GUTTER.right;
    context.save();
    context.beginPath();
    context.rect(GUTTER.left, this.top, wide, this.bottom - this.top + 1);
    context.clip();
    if (watch.isDense(pen.from, pen.to, wide)) {
      this.#drawColumns(pen, watch, toY, Math.ceil(wide / COLUMN));
      context.restore();
      return;
    }
    const curves = watch.curves(pen.from, pen.to);
    for (const curve of curves) {
      const region = (field, edge) => {
        const path = line(curve, field);
        path.lineTo(toX(curve.at(-1).t), edge);
        path.lineTo(toX(curve[0].t), edge);
        path.closePath();
        return path;
      };
      const between = (under, above, color, opacity) => {
        context.save();
        context.clip(region(under, this.bottom));
        context.fillStyle = color;
        context.globalAlpha = opacity;
        context.fill(region(above, this.top - surface.height));
        context.restore();
      };
      between("distance", "required", palette[watch.person.color], 0.1);    // the margin
      between("required", "distance", palette.danger, 0.35);                // the shortfall
    }
    drawViolationBands(pen, watch, this.top, this.bottom - this.top);
    context.lineJoin = "round";
    const stroke = (curve, field, color, width, dash) => {
      context.strokeStyle = color;
      context.lineWidth = width;
      context.setLineDash(dash);
      context.stroke(line(curve, field));
    };
    for (const curve of curves) {
      stroke(curve, "notice", palette.muted, 1, [1, 3]);
      stroke(curve, "required", palette.danger, 1.25, [5, 3]);
      stroke(curve, "distance", palette[watch.person.color], 1.75, []);
    }
    context.restore();
    this.#drawClosest(pen, watch, toY);
  }

  /** The speeds of all people, or of all machines, where there is no pair of bodies to look at. */
  #drawSpeeds(pen) {
    const { context, palette, from, to, toX } = pen;
    const count = Math.round(toX(to) - toX(from));
    const curves = this.run.paced.map(({ motion, color }) => ({
      color, speeds: Array.from({ length: count + 1 }, (_, i) => motion.at(from + ((to - from) * i) / count).speed),
    }));
    const highest = 1.1 * Math.max(1, ...curves.map(({ speeds }) => Math.max(...speeds)));
    const toY = value => this.bottom - (value / highest) * (this.bottom - this.top);
    this.#drawScale(pen, toY, highest, "m/s");
    context.lineWidth = curves.length > FEW ? 1 : 1.5;
    for (const { color, speeds } of curves) {
      const path = new Path2D();
      speeds.forEach((speed, i) => path.lineTo(GUTTER.left + i, toY(speed)));
      context.strokeStyle = palette[color];
      context.stroke(path);
    }
  }

  /** What is too dense for curves: in each column the nearest distance (a line), and all others (tinted). */
  #drawColumns({ context, palette, from, to, toX }, watch, toY, count) {
    const columns = watch.columns(from, to, count).filter(({ nearest }) => nearest < Infinity);
    const color = palette[watch.person.color];
    const line = field => {
      const path = new Path2D();
      for (const column of columns) path.lineTo(toX(column.t), toY(column[field]));
      return path;
    };
    const tinted = line("nearest");
    for (const column of [...columns].reverse()) tinted.lineTo(toX(column.t), toY(column.farthest));
    context.fillStyle = color;
    alpha(context, 0.14, () => context.fill(tinted));
    context.lineJoin = "round";
    context.strokeStyle = palette.danger;
    context.lineWidth = 1.25;
    context.setLineDash([5, 3]);
    context.stroke(line("required"));
    context.setLineDash([]);
    context.strokeStyle = color;
    context.lineWidth = 1.5;
    context.stroke(line("nearest"));
  }

  #drawScale({ context, palette, surface }, toY, highest, unit = "m") {
    context.strokeStyle = palette.line;
    context.lineWidth = 1;
    const step = [0.5, 1, 2, 5, 10, 20, 50].find(s => (s / highest) * (this.bottom - this.top) >= 22) ?? 100;
    for (let value = 0; value <= highest; value += step) {
      const y = Math.round(toY(value)) + 0.5;
      context.globalAlpha = value ? 0.5 : 1;
      context.beginPath();
      context.moveTo(GUTTER.left, y);
      context.lineTo(surface.width - GUTTER.right, y);
      context.stroke();
      context.globalAlpha = 1;
      drawText(context, value + step > highest ? `${value} ${unit}` : `${value}`, GUTTER.left - 7, y,
        { color: palette.muted, size: 11, align: "right" });
    }
  }

  /** Draws the minimum separation of the summary, if it is that of this watch. */
  #drawClosest({ context, palette, from, to, toX }, watch, toY) {
    const { minimum_separation: ofAll, people } = this.run.recording.summary ?? {};
    const found = people?.[watch.person.name]?.minimum_separation ?? ofAll;
    if (!found || watch.other.category !== "robot") return;
    const fits = state => Math.abs(state.distance - found.distance) < SAME;
    if (!fits(watch.at(found.time)) && !fits(watch.before(found.time))) return;
    if (found.time < from || found.time > to) return;
    context.beginPath();
    context.arc(toX(found.time), toY(found.distance), 3.5, 0, 2 * Math.PI);
    context.fillStyle = palette.card;
    context.strokeStyle = palette[watch.person.color];
    context.lineWidth = 1.75;
    context.fill();
    context.stroke();
  }

  #drawRows(pen, watch) {
    const { context, palette, toX, surface } = pen;
    for (const row of ROWS) {
      const y = this.rowY(row);
      drawText(context, row, GUTTER.left - 7, y, { color: palette.muted, size: 11, align: "right" });
      context.fillStyle = palette.line;
      context.fillRect(GUTTER.left, Math.round(y), surface.width - GUTTER.left - GUTTER.right, 1);
    }
    context.save();
    context.beginPath();
    context.rect(GUTTER.left - 6, this.bottom, surface.width - GUTTER.left - GUTTER.right + 12, surface.height);
    context.clip();
    if (this.isDense) {
      this.#drawCounts(pen);
      context.restore();
      return;
    }
    const y = this.rowY("safety") - 4;
    context.fillStyle = palette.robot;
    for (const { begins, ends } of this.run.disabled.values()) {
      begins.forEach((begin, i) => {
        const wide = Math.max(2, toX(ends[i]) - toX(begin));
        alpha(context, 0.4, () => context.fillRect(toX(begin), y, wide, 8));
      });
    }
    if (watch) drawViolationBands(pen, watch, y, 8);
    for (const { event, look } of this.marks) {
      if (event.t < pen.from || event.t > pen.to) continue;
      drawGlyph(context, look, toX(event.t), this.rowY(look.row), palette, 0.8);
    }
    context.restore();
  }

  /** What is too dense for marks: in each column a bar, the higher the more events, violations in their colour. */
  #drawCounts({ context, palette, toX, surface }) {
    const count = Math.ceil((surface.width - GUTTER.left - GUTTER.right) / COLUMN);
    for (const row of ROWS) {
      const all = new Uint32Array(count + 1);
      const violations = new Uint32Array(count + 1);
      for (const { event, look } of this.marks) {
        const i = Math.floor((toX(event.t) - GUTTER.left) / COLUMN);
        if (look.row !== row || i < 0 || i > count) continue;
        all[i] += 1;
        if (event.kind === "violation") violations[i] += 1;
      }
      const most = Math.max(...all);
      const base = this.rowY(row) + ROW_HEIGHT / 2 - 2;
      all.forEach((number, i) => {
        const bar = (part, color) => {
          const high = part && Math.max(2, (part / most) * (ROW_HEIGHT - 3));
          context.fillStyle = color;
          context.fillRect(GUTTER.left + i * COLUMN, base - high, COLUMN - 1, high);
        };
        bar(number, palette.muted);
        bar(violations[i], palette.danger);
      });
    }
  }
}

/** The highest distance of a plot; larger ones are cut off. */
function highestOf({ largest, isOfPeople }) {
  return Math.min(largest.distance * 1.05, isOfPeople ? SOCIAL : Math.max(SOCIAL, largest.required * 3));
}

function drawViolationBands({ context, palette, from, to, toX, surface }, watch, top, height) {
  const hatch = hatching(context, palette.danger, surface.ratio);
  for (const [begin, end] of watch.violations) {
    if (end < from || begin > to) continue;
    const x = toX(begin);
    const width = Math.max(2, toX(end) - x);
    context.fillStyle = palette.danger;
    alpha(context, 0.16, () => context.fillRect(x, top, width, height));
    context.fillStyle = hatch;
    alpha(context, 0.5, () => context.fillRect(x, top, width, height));
  }
}
