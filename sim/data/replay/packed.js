/* Motions and minds of a long recording, which are read when they are needed. */

const BLOCK = 512;             // pieces of a motion in a block
const UNIT = 1e9;              // integers to a second, metre or radian
const AXES = [2, 6, 10];       // the first column of each axis in a row: begin, end, x0…x3, y0…y3, r0…r3
const NOTHING = new Uint8Array();

/**
 * The pieces of one body in `bytes`, as far as they go, by `index`: {count, jumps, blocks: [[begin, gone, at, size], …]}.
 * How a block is written stands in `sim/views/replay.py`.
 */
class PackedPieces {
  constructor({ count, jumps, blocks }, bytes) {
    this.blocks = blocks.filter(([, , at, size]) => at + size <= bytes.length);
    this.length = Math.min(count, BLOCK * this.blocks.length);
    this.jumps = jumps.filter(i => i < this.length);
    this.begins = Float64Array.from(this.blocks, ([begin]) => begin);
    this.gone = Float64Array.from(this.blocks, ([, gone]) => gone);
    this.isRead = new Uint8Array(this.blocks.length);
    this.bytes = bytes;
  }

  /** Reads a block into the arrays of a motion. */
  read(block, { begins, ends, coefficients }) {
    this.isRead[block] = 1;
    const first = block * BLOCK;
    const last = Math.min(this.length, first + BLOCK);
    const { bytes } = this;
    let head = this.blocks[block][2];
    let place = head + last - first;
    const next = () => {
      let coded = 0;
      let unit = 1;
      for (;;) {
        const byte = bytes[place++];
        coded += (byte & 127) * unit;
        if (!(byte > 127)) return coded % 2 ? -(coded + 1) / 2 : coded / 2;
        unit *= 128;
      }
    };
    const row = new Float64Array(14);
    for (let i = first; i < last; i++) {
      const lengths = bytes[head++];
      row[0] = row[1] + next();
      const duration = next();
      row[1] = row[0] + duration;
      const u = duration / UNIT;
      begins[i] = row[0] / UNIT;
      ends[i] = row[1] / UNIT;
      for (let axis = 0; axis < 3; axis++) {
        const k = AXES[axis];
        const length = 1 + ((lengths >> (2 * axis)) & 3);
        // At first row has, of place and velocity, those in which the piece before ended.
        row[k] += next();
        row[k + 1] = length > 1 ? row[k + 1] + next() : 0;
        row[k + 2] = length > 2 ? next() : 0;
        row[k + 3] = length > 3 ? next() : 0;
        const [c1, c2, c3] = [row[k + 1] / UNIT, row[k + 2] / UNIT, row[k + 3] / UNIT];
        const at = 12 * i + k - 2;
        coefficients[at] = row[k] / UNIT;
        coefficients[at + 1] = c1;
        coefficients[at + 2] = c2;
        coefficients[at + 3] = c3;
        row[k] += Math.floor(UNIT * (u * (c1 + u * (c2 + u * c3))) + 0.5);
        row[k + 1] += Math.floor(UNIT * (u * (2 * c2 + u * (3 * c3))) + 0.5);
      }
    }
  }

  /** All pieces as they stand in a recording that is not packed. */
  unpacked() {
    const arrays = {
      begins: new Float64Array(this.length), ends: new Float64Array(this.length), coefficients: new Float64Array(12 * this.length),
    };
    this.blocks.forEach((_, block) => this.read(block, arrays));
    const { begins, ends, coefficients } = arrays;
    return Array.from(begins, (begin, i) => [begin, ends[i], ...AXES.map((k, axis) => {
      const at = 12 * i + k - 2;
      const head = this.bytes[this.blocks[Math.floor(i / BLOCK)][2] + (i % BLOCK)];
      return [...coefficients.subarray(at, at + 1 + ((head >> (2 * axis)) & 3))];
    })]);
  }
}

/**
 * Makes a recording whole that stands in its page in three parts: `motions` has its blocks (bytes), and `rest` lines
 * of JSON, of which the first has the events, and the others a person's mind each. What is packed is unpacked
 * when somebody asks for it.
 */
function addParts(recording, motions, rest) {
  const lines = rest.split("\n");
  recording.events = parsedPart(lines[0])?.events ?? [];
  const sources = new Map();
  for (const [name, index] of Object.entries(recording.motions ?? {})) {
    if (!isPackedIndex(index)) continue;
    const pieces = new PackedPieces(index, motions);
    sources.set(name, pieces);
    onDemand(recording.motions, name, () => pieces.unpacked());
  }
  Object.defineProperty(recording, "sources", { value: sources });
  for (const [name, number] of Object.entries(recording.minds ?? {})) {
    if (Number.isInteger(number)) onDemand(recording.minds, name, () => thoughtsIn(lines[number], name));
  }
}

/** The pieces of a body, packed or as a list. */
const piecesOf = (recording, name) => recording.sources?.get(name) ?? recording.motions?.[name];

function thoughtsIn(line, name) {
  const thoughts = parsedPart(line)?.minds?.[name];
  return Array.isArray(thoughts) && thoughts.every(isThought) ? thoughts : [];
}

/** The JSON of a line, or as much of it as is whole; null if there is none. */
function parsedPart(line) {
  try {
    return JSON.parse(line);
  } catch {
    return parseWholePart(line ?? "");
  }
}

/** Gives an object a property with a value that is worked out once, when somebody asks for it. */
function onDemand(object, name, make) {
  Object.defineProperty(object, name, {
    configurable: true,
    enumerable: true,
    get() {
      const value = make();
      Object.defineProperty(object, name, { value, enumerable: true, writable: true, configurable: true });
      return value;
    },
  });
}

function isPackedIndex(index) {
  const isBlock = block => isNumbers(block) && block.length === 4;
  return isObject(index) && Number.isInteger(index.count) && isNumbers(index.jumps)
    && Array.isArray(index.blocks) && index.blocks.every(isBlock) && index.count <= BLOCK * index.blocks.length;
}
