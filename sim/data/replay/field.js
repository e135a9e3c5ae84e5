/* Density and mean speed of people as fields over the floor. */

const KERNEL = 1;              // metres: full width at half maximum of the Gaussian over which a person is spread
const STEEPNESS = (4 * Math.LN2) / KERNEL ** 2;      // a person is exp(-STEEPNESS r²) as dense r metres off as in the middle
const SUMMIT = STEEPNESS / Math.PI;                  // people per m² in the middle of one, so that there is one in all
const SPREAD = 2 * KERNEL;     // metres beyond which nothing is left of a person
const CELL = 0.2;              // metres of a cell
const MOST_CELLS = 300;        // along a side; of a large floor cells are larger
const LOOKS_AT_RUN = 4000;     // instants at which a whole run is looked at, at most
const LOOKS_FOR_PEAK = 200;    // the same, for the highest density at an instant
const LOOK_EVERY = 0.1;        // seconds between them, at least
const OPAQUE = 0.7;            // of the floor under a field, so much is covered
const FAINT = 0.005;           // people per m² below which nothing is said
const DENSE_ENOUGH = 0.1;      // people per m² from which a speed is shown in full

/** What can be shown: words, unit, and whether the scale is that of a whole run, which spreads low values. */
const FIELDS = {
  density: { words: "density", unit: "1/m²" },
  speed: { words: "mean speed", unit: "m/s" },
  "run-density": { words: "mean density of the run", unit: "1/m²", isOfRun: true },
  "run-speed": { words: "mean speed in the run", unit: "m/s", isOfRun: true },
};

/** A sequence of colours that everybody can tell apart (viridis), from low to high. */
const RAMP = ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725"];

/**
 * The fields of a run. Density is the sum of people, each spread by a Gaussian; speed their mean, weighted by the
 * same (the Gaussian profiles of PedPy). Over a run density is the mean over time, speed weighted by density.
 */
class Fields {
  constructor(run) {
    this.run = run;
    this.bounds = boxOf(run.plan.boundary);
    const { left, right, bottom, top } = this.bounds;
    this.cell = Math.max(CELL, Math.max(right - left, top - bottom) / MOST_CELLS);
    this.left = left;
    this.bottom = bottom;
    this.columns = Math.ceil((right - left) / this.cell);
    this.rows = Math.ceil((top - bottom) / this.cell);
    this.peaks = new Map();
  }

  /** The values of a kind at t, and how dense people are: {values, density}, row by row from the south. */
  at(kind, t) {
    const { density, flow } = FIELDS[kind].isOfRun ? this.#ofRun() : this.#atOnce(t);
    return { density, values: kind.endsWith("density") ? density : flow.map((sum, i) => (density[i] > 0 ? sum / density[i] : 0)) };
  }

  /** The value in the cell at a place of the floor, the density there, and its middle: {value, density, x, y}. */
  valueAt(kind, t, x, y) {
    const [column, row] = [Math.floor((x - this.left) / this.cell), Math.floor((y - this.bottom) / this.cell)];
    if (column < 0 || row < 0 || column >= this.columns || row >= this.rows) return null;
    const { values, density } = this.at(kind, t);
    const i = row * this.columns + column;
    const middle = { x: this.left + (column + 0.5) * this.cell, y: this.bottom + (row + 0.5) * this.cell };
    return { value: values[i], density: density[i], ...middle };
  }

  /** About the highest value of a kind in the run. */
  peak(kind) {
    if (!this.peaks.has(kind)) this.peaks.set(kind, this.#peak(kind));
    return this.peaks.get(kind);
  }

  #peak(kind) {
    const { run } = this;
    if (kind === "run-density") return this.at(kind, 0).values.reduce((a, b) => Math.max(a, b), 0);
    const looks = this.#looks(LOOKS_FOR_PEAK).map(t => this.#people(t));
    if (kind !== "density") return Math.max(0, ...looks.flat().map(({ speed }) => speed));
    return Math.max(0, ...looks.flatMap(people => people.map(at => people.reduce((sum, other) => (
      sum + SUMMIT * Math.exp(-STEEPNESS * ((at.x - other.x) ** 2 + (at.y - other.y) ** 2))), 0))));
  }

  /** Instants spread over the part of the run that is known, in the middles of equal steps. */
  #looks(most) {
    const count = Math.max(1, Math.min(most, Math.floor(this.run.known / LOOK_EVERY)));
    return Array.from({ length: count }, (_, i) => ((i + 0.5) / count) * this.run.known);
  }

  #people(t) {
    return this.run.people.map(person => person.motion.at(t)).filter(at => !isAway(at, this));
  }

  #atOnce(t) {
    this.once ??= this.#empty();
    this.once.density.fill(0);
    this.once.flow.fill(0);
    for (const at of this.#people(t)) this.#add(this.once, at, 1);
    return this.once;
  }

  #ofRun() {
    if (this.whole) return this.whole;
    this.whole = this.#empty();
    const looks = this.#looks(LOOKS_AT_RUN);
    for (const t of looks) for (const at of this.#people(t)) this.#add(this.whole, at, 1 / looks.length);
    return this.whole;
  }

  #empty() {
    const size = this.rows * this.columns;
    return { density: new Float64Array(size), flow: new Float64Array(size) };
  }

  /** Adds somebody at {x, y, speed} to all cells near them. */
  #add({ density, flow }, { x, y, speed }, weight) {
    const { cell, left, bottom, columns, rows } = this;
    const [west, east] = [-1, 1].map(side => Math.floor((x + side * SPREAD - left) / cell));
    const [south, north] = [-1, 1].map(side => Math.floor((y + side * SPREAD - bottom) / cell));
    for (let row = Math.max(0, south); row <= Math.min(rows - 1, north); row++) {
      const across = weight * SUMMIT * Math.exp(-STEEPNESS * (bottom + (row + 0.5) * cell - y) ** 2);
      for (let column = Math.max(0, west); column <= Math.min(columns - 1, east); column++) {
        const share = across * Math.exp(-STEEPNESS * (left + (column + 0.5) * cell - x) ** 2);
        density[row * columns + column] += share;
        flow[row * columns + column] += share * speed;
      }
    }
  }
}

/** How a field is shown: `kind`, the colours of the theme and the value `top` of the last of them. */
class FieldScale {
  constructor(kind, runs, isDark) {
    const { isOfRun } = FIELDS[kind];
    this.kind = kind;
    this.top = roundUp(Math.max(...runs.map(run => run.fields.peak(kind))));
    this.power = isOfRun && kind.endsWith("density") ? 0.5 : 1;
    this.ramp = (isDark ? RAMP : [...RAMP].reverse()).map(channels);
    this.css = `linear-gradient(to right, ${this.ramp.map(rgb => `rgb(${rgb.join()})`)})`;
  }

  isLike(other) { return other?.kind === this.kind && other.top === this.top && other.css === this.css; }

  /** The value at a share of the scale, 0 to 1. */
  valueOf(share) { return this.top * share ** (1 / this.power); }

  /** The colour of a value and how opaque it is: [r, g, b, 0 to 1]. */
  look(value, density) {
    const share = Math.min(1, (value / this.top) ** this.power);
    const place = share * (this.ramp.length - 1);
    const low = Math.min(Math.floor(place), this.ramp.length - 2);
    const [from, to] = [this.ramp[low], this.ramp[low + 1]];
    const isThere = this.kind.endsWith("density") ? 4 * share : density / (FIELDS[this.kind].isOfRun ? 1e-3 : DENSE_ENOUGH);
    return [...[0, 1, 2].map(i => from[i] + (place - low) * (to[i] - from[i])), OPAQUE * Math.min(1, isThere)];
  }
}

const channels = color => [1, 3, 5].map(i => parseInt(color.slice(i, i + 2), 16));

/** The next number of 1, 2, 3, 5 and ten times these that is no smaller. */
function roundUp(value) {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  return power * [1, 2, 3, 5, 10].find(step => step * power >= value * (1 - 1e-9));
}

/** Draws a field over the floor. */
function drawField({ context, camera }, run, scale, t) {
  const { fields } = run;
  const { rows, columns, cell, left, bottom } = fields;
  const { values, density } = fields.at(scale.kind, t);
  const canvas = fields.canvas ??= Object.assign(document.createElement("canvas"), { width: columns, height: rows });
  const pen = canvas.getContext("2d");
  const image = pen.createImageData(columns, rows);
  for (let row = 0; row < rows; row++) {
    for (let column = 0; column < columns; column++) {
      const i = row * columns + column;
      if (density[i] === 0) continue;
      const [r, g, b, opacity] = scale.look(values[i], density[i]);
      image.data.set([r, g, b, 255 * opacity], 4 * ((rows - 1 - row) * columns + column));
    }
  }
  pen.putImageData(image, 0, 0);
  context.save();
  outline(context, camera, run.plan.boundary, ...run.plan.holes ?? []);
  context.clip("evenodd");
  const [px, py] = camera.toScreen(left, bottom + rows * cell);
  context.imageSmoothingEnabled = true;
  context.drawImage(canvas, px, py, columns * cell * camera.scale, rows * cell * camera.scale);
  context.restore();
}

/** Adds a field to a pile of shapes, as tiles on the floor. */
function addField(pile, run, scale, t, height) {
  const { fields } = run;
  const { rows, columns, cell, left, bottom } = fields;
  const { values, density } = fields.at(scale.kind, t);
  for (let row = 0; row < rows; row++) {
    for (let column = 0; column < columns; column++) {
      const i = row * columns + column;
      if (density[i] === 0) continue;
      const [x, y] = [left + (column + 0.5) * cell, bottom + (row + 0.5) * cell];
      const [r, g, b, opacity] = scale.look(values[i], density[i]);
      if (opacity < 0.02 || !isInside(run.plan.boundary, x, y)) continue;
      pile.add("square", "glow", sized(frameAt(x, y, height), cell, cell, 1), [r, g, b].map(channel => (channel / 255) ** 2.2), opacity);
    }
  }
}

/** The scale of a field with its figures; hidden where none is shown. */
function showFieldScale(box, scale) {
  box.hidden = !scale;
  if (!scale) return;
  const { words, unit } = FIELDS[scale.kind];
  const figure = value => String(Number(value.toPrecision(2)));
  write(box.querySelector("p"), `${words}, ${unit}`);
  box.querySelector("i").style.background = scale.css;
  box.querySelectorAll("span").forEach((span, i) => write(span, figure(scale.valueOf(i / 2))));
}
