/* Motions of a long recording as columns of numbers, and minds that are read when they are needed. */

const BLOCK = 512;             // pieces of a motion in a block
const NUMBERS = 14;            // of a piece: begin, end, and four coefficients for x, y and rotation
const NOTHING = new Uint8Array();

/**
 * The pieces of one body in `bytes`, as far as they go: it has `count` of them, and the byte at which each of
 * its `blocks` begins. A block has the begins, the ends and the coefficients (x0…x3, y0…y3, r0…r3 of each piece).
 */
class PackedPieces {
  constructor({ count, blocks }, bytes) {
    const sizes = blocks.map((_, k) => Math.min(BLOCK, count - BLOCK * k));
    const there = blocks.filter((at, k) => at + 8 * NUMBERS * sizes[k] <= bytes.length).length;
    this.length = Math.min(count, BLOCK * there);
    this.begins = new Float64Array(this.length);
    this.ends = new Float64Array(this.length);
    this.coefficients = new Float64Array(12 * this.length);
    for (let k = 0; k < there; k++) {
      const numbers = new Float64Array(bytes.buffer, blocks[k], NUMBERS * sizes[k]);
      this.begins.set(numbers.subarray(0, sizes[k]), BLOCK * k);
      this.ends.set(numbers.subarray(sizes[k], 2 * sizes[k]), BLOCK * k);
      this.coefficients.set(numbers.subarray(2 * sizes[k]), 12 * BLOCK * k);
    }
  }

  /** All pieces as a recording in JSON has them: without zeros at the ends of cubics. */
  listed() {
    return Array.from(this.begins, (begin, i) => [begin, this.ends[i], ...[0, 4, 8].map(axis => {
      const cubic = this.coefficients.subarray(12 * i + axis, 12 * i + axis + 4);
      return [...cubic.subarray(0, Math.max(1, cubic.findLastIndex(c => c !== 0) + 1))];
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
    onDemand(recording.motions, name, () => pieces.listed());
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
  return isObject(index) && Number.isInteger(index.count) && isNumbers(index.blocks)
    && index.blocks.length === Math.ceil(index.count / BLOCK);
}
