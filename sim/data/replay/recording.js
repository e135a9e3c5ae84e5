/* Reads a recording, or says what is wrong with it. */

const FORMAT = "floorwalker-replay/1";
const MEASURES = {
  person: ["radius"],
  robot: ["length", "width"],
  vehicle: ["length", "width"],
};
const MOST_PROBLEMS = 8;
const CUT_OFF = "the recording is cut off or damaged; this is what there is of it";

class RecordingError extends Error {
  constructor(problems) {
    super(problems.join("; "));
    this.problems = problems;
  }
}

/** The recording in this page, or the other one. Throws RecordingError with every problem found in it. */
function readRecording(name = "recording") {
  if (!document.getElementById(name)) throw new RecordingError(["the page is cut off: it holds no recording"]);
  return recordingIn(document, name);
}

/** The recording in a file: JSON, or a replay page like this one. */
async function readFile(text) {
  if (!/^\s*</.test(text)) return parseRecording(text);
  const page = new DOMParser().parseFromString(text, "text/html");
  if (!page.getElementById("recording")) throw new RecordingError(["this is not a replay page: it contains no recording"]);
  return recordingIn(page, "recording");
}

/** The recording of that name in a page: as JSON in one element, or a long one packed in three. */
async function recordingIn(page, name) {
  const element = page.getElementById(name);
  if (!element.dataset.packed) return parseRecording(element.textContent);
  const [first, motions, rest] = await Promise.all(
    [name, `${name}-motions`, `${name}-rest`].map(part => contentOf(page.getElementById(part))));
  const text = bytes => new TextDecoder().decode(bytes);
  return parseRecording(text(first.bytes), recording => {
    addParts(recording, motions.bytes, text(rest.bytes));
    return first.isWhole && motions.isWhole && rest.isWhole ? [] : [CUT_OFF];
  });
}

/** What is packed in an element (zlib, as base64): {bytes, isWhole}. */
function contentOf(element) {
  if (!element) return { bytes: NOTHING, isWhole: false };
  if (!("DecompressionStream" in window)) {
    throw new RecordingError(["the recording is packed, which this browser can't undo: take a newer one"]);
  }
  return unpacked(bytesIn(element.textContent));
}

/**
 * The recording in a text, or as much of it as is whole. `addRest` adds what does not stand in the text, and returns
 * lines about what is missing.
 */
function parseRecording(text, addRest = () => []) {
  let [recording, notices] = [null, []];
  try {
    recording = JSON.parse(text);
  } catch (why) {
    notices = [`${CUT_OFF} (${why.message})`];
    recording = parseWholePart(text);
    if (!isObject(recording?.floorplan)) throw new RecordingError([`the recording is cut off or damaged (${why.message})`]);
    recording = { motions: {}, events: [], watches: [], ...recording };
  }
  if (isObject(recording)) {
    const missing = addRest(recording);
    notices.push(...notices.length ? [] : missing, ...takeWhatThereIs(recording));
    if (Array.isArray(recording.notices)) notices.push(...recording.notices.map(String));
  }
  const problems = problemsOf(recording);
  if (problems.length) throw new RecordingError([...notices, ...problems]);
  return Object.defineProperty(recording, "notices", { value: notices });
}

function parseWholePart(text) {
  try {
    return JSON.parse(wholePart(text));
  } catch {
    return null;
  }
}

/**
 * Makes a recording of a later version, or one without the motions of somebody, as much of one as can be
 * shown; returns what is missing, in lines.
 */
function takeWhatThereIs(recording) {
  const notices = [];
  const { format, bodies, watches } = recording;
  if (/^floorwalker-replay\/([2-9]|\d\d+)$/.test(format)) {
    notices.push(`made in the later format ${format}; this page reads ${FORMAT}, and shows it as far as it goes`);
    recording.format = FORMAT;
  }
  if (!Array.isArray(bodies) || !Array.isArray(watches)) return notices;
  const isStill = body => !(piecesOf(recording, body?.name)?.length > 0);
  const missing = bodies.filter(isStill).map(body => body?.name);
  if (!missing.length) return notices;
  recording.bodies = bodies.filter(body => !isStill(body));
  recording.watches = watches.filter(watch => !missing.includes(watch?.person) && !missing.includes(watch?.other));
  notices.push(`without the motions of ${missing.map(name => spoken(name)).join(", ")}, who can't be shown`);
  return notices;
}

function problemsOf(recording) {
  const problems = [];
  const check = (holds, field, wanted) => {
    if (!holds) problems.push(`${field}: ${wanted}`);
    return holds;
  };
  const list = (value, field) => (check(Array.isArray(value), field, "a list is missing") ? value : []);
  const each = (values, field, wanted, holds) => list(values, field).forEach(
    (value, i) => check(holds(value, values[i - 1]), `${field}[${i}]`, wanted));
  const isPoint = value => isNumbers(value) && value.length === 2;
  const isLine = value => Array.isArray(value) && value.length >= 2 && value.every(isPoint);
  const isRing = value => Array.isArray(value) && value.length >= 3 && value.every(isPoint);

  if (!isObject(recording)) return ["the recording is not an object"];
  if (recording.format !== FORMAT) {
    return [`format: this page reads ${FORMAT}, not ${JSON.stringify(recording.format)}`];
  }
  check(recording.duration > 0, "duration", "a number of seconds above 0 is missing");

  const plan = recording.floorplan;
  if (check(isObject(plan), "floorplan", "missing")) {
    check(isRing(plan.boundary), "floorplan.boundary", "a list of points [x, y] is missing");
    if (plan.holes) {
      const areRings = Array.isArray(plan.holes) && plan.holes.every(isRing);
      check(areRings, "floorplan.holes", "needs lists of points [x, y]");
    }
    each(plan.obstacles, "floorplan.obstacles", "needs a footprint of points [x, y], a bottom and a top",
      obstacle => isRing(obstacle?.footprint) && isNumbers([obstacle.bottom, obstacle.top]));
    if (plan.zones) {
      each(plan.zones, "floorplan.zones", "a footprint of points [x, y] is missing", zone => isRing(zone?.footprint));
    }
    if (plan.gates) {
      each(plan.gates, "floorplan.gates", "needs two ends [x, y] and a direction",
        gate => isLine(gate?.ends) && isPoint(gate.direction));
    }
    each(plan.stations, "floorplan.stations", "a point [x, y] is missing: at", station => isPoint(station?.at));
    each(plan.lanes, "floorplan.lanes", "needs points from and to, and locations",
      lane => isPoint(lane?.from) && isPoint(lane.to) && isObject(lane.locations)
        && Object.values(lane.locations).every(isPoint));
    if (plan.safe_zone) {
      check(isPoint(plan.safe_zone.at), "floorplan.safe_zone.at", "a point [x, y] is missing");
    }
    if (plan.gantry) {
      check(isPoint(plan.gantry.x) && isPoint(plan.gantry.y), "floorplan.gantry", "needs ranges x and y");
    }
  }

  const bodies = list(recording.bodies, "bodies");
  bodies.forEach((body, i) => {
    const categories = Object.keys(MEASURES).join(", ");
    if (!check(MEASURES[body?.category], `bodies[${i}].category`, `must be one of ${categories}`)) return;
    const measures = [...MEASURES[body.category], ..."reach" in body ? ["reach", "mount"] : []];
    check(isNumbers(measures.map(name => body[name])), `bodies[${i}]`, `needs numbers: ${measures.join(", ")}`);
    if (body.course) check(isLine(body.course), `bodies[${i}].course`, "needs points [x, y]");
    if (body.bridge) check(isPoint(body.bridge), `bodies[${i}].bridge`, "needs a range of y");
    const field = `motions.${body.name}`;
    const pieces = piecesOf(recording, body.name);
    if (pieces instanceof PackedPieces) return;
    if (!check(Array.isArray(pieces) && pieces.length > 0, field, "needs at least one piece")) return;
    const wrong = pieces.findIndex((piece, k) => !isPiece(piece, pieces[k - 1]));
    check(wrong < 0, `${field}[${wrong}]`,
      "must be [begin, end, x, y, rotation] with numbers, each piece after the one before");
  });

  each(recording.events, "events", "needs a kind, and a time t not before that of the event before it",
    (event, before) => Number.isFinite(event?.t) && typeof event.kind === "string" && !(before?.t > event.t));
  list(recording.watches, "watches").forEach((watch, i) => {
    for (const role of ["person", "other"]) {
      const isThere = bodies.some(body => body?.name === watch?.[role]);
      check(isThere, `watches[${i}].${role}`, `there is no body called ${JSON.stringify(watch?.[role])}`);
    }
    check(isLaw(watch?.law), `watches[${i}].law`, LAW_WANTED);
    if (watch?.notice_law) check(isLaw(watch.notice_law), `watches[${i}].notice_law`, LAW_WANTED);
    check(Array.isArray(watch?.violations) && watch.violations.every(isPoint),
      `watches[${i}].violations`, "a list of [begin, end] is missing");
  });
  if (recording.minds !== undefined) check(isObject(recording.minds), "minds", "needs lists by person");
  for (const name of Object.keys(recording.minds ?? {})) {
    if (Object.getOwnPropertyDescriptor(recording.minds, name).get) continue; // packed, and checked when it is read
    each(recording.minds[name], `minds.${name}`, "needs a time t not before that of the thought before it, and lists",
      (thought, before) => isThought(thought) && !(before?.t > thought.t));
  }
  return problems;
}

function isThought(thought) {
  const areLists = ["steps", "believes", "forgets", "intends"]
    .every(name => thought?.[name] === undefined || Array.isArray(thought[name]));
  const steps = thought?.steps ?? [];
  const intends = thought?.intends ?? [];
  const areTexts = values => Array.isArray(values) && values.every(value => typeof value === "string");
  return Number.isFinite(thought?.t) && areLists && steps.every(areTexts)
    && areTexts(thought.believes ?? []) && areTexts(thought.forgets ?? [])
    && intends.every(intention => areTexts(intention?.stack));
}

function isPiece(piece, before) {
  return Array.isArray(piece) && piece.length === 5 && isNumbers(piece.slice(0, 2))
    && piece[0] <= piece[1] && (!before || before[1] <= piece[0])
    && piece.slice(2).every(c => isNumbers(c) && c.length >= 1 && c.length <= 4);
}

const LAW_WANTED = "needs a distance, a curve, or t1, t2, stopping and intrusion";

function isLaw(law) {
  if (!isObject(law)) return false;
  if ("curve" in law) {
    const isCurve = Array.isArray(law.curve) && law.curve.length > 0;
    return isCurve && law.curve.every((point, i) =>
      isNumbers(point) && point.length === 2 && !(law.curve[i - 1]?.[0] > point[0]));
  }
  return isNumbers("distance" in law ? [law.distance] : [law.t1, law.t2, law.stopping, law.intrusion]);
}

function isObject(value) {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

function isNumbers(values) {
  return Array.isArray(values) && values.every(Number.isFinite);
}
