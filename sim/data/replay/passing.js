/* Zones and one-way gates of the floor, and what is not always there: closed doors, and obstacles that come and go. */

const COMES = ["door_closed", "obstacle_came"];
const GOES = ["door_opened", "obstacle_went"];

/**
 * What is not always there: `things`, those in the `passing` of a recording and those that somebody outside put
 * down, and the `turns` {t, name, thing} at which the thing of that name is another one, or (null) none.
 */
function comings(events, passing = []) {
  const things = [...passing];
  const known = new Map(passing.map(thing => [thing.name, thing]));
  const turns = [];
  for (const event of events) {
    if (event.kind === "commanded" && event.block) {
      const { block: name, footprint, bottom, top } = event;
      things.push({ name, footprint, bottom, top, isPlaced: true });
      known.set(name, things.at(-1));
    }
    const name = event.door ?? event.obstacle;
    if (COMES.includes(event.kind)) turns.push({ t: event.t, name, thing: known.get(name) ?? null });
    if (GOES.includes(event.kind)) turns.push({ t: event.t, name, thing: null });
  }
  return { things, turns };
}

/** The things that are there at t. */
function thereAt({ comings: { turns } }, t) {
  const there = new Map();
  for (const { t: begin, name, thing } of turns) {
    if (begin > t) break;
    there.set(name, thing);
  }
  return [...there.values()].filter(Boolean);
}

/** Metres. The side of a part on the conveyor, and its height; and pixels of it, at least. */
const PART_SIZE = 0.14, PART_HEIGHT = 0.06, PART_PIXELS = 5;
/** The side with which a part is drawn at so many pixels a metre, metres. */
const partSize = scale => Math.min(0.5, Math.max(PART_SIZE, PART_PIXELS / scale));
const PART_PAINTS = { blue: "#2f6fb5", green: "#3a9d5d", orange: "#d9822b", purple: "#7d4fa8", red: "#c0392b" };

/** The parts that come along the conveyor: {part, t, falls, at, to}, and `end`, when they are gone. */
function conveyed(events) {
  const parts = new Map();
  for (const event of events) {
    if (event.kind === "part_came") parts.set(event.number, { ...event, end: event.falls });
    const part = parts.get(event.number);
    if (part && (event.kind === "part_taken" || event.kind === "part_missed")) part.end = event.t;
  }
  return [...parts.values()];
}

/** Those that lie there at t: {x, y, paint}. */
function conveyedAt({ conveyed: parts }, t) {
  return parts.filter(part => part.t <= t && t < part.end).map(({ part, t: begin, falls, at, to }) => {
    const share = (t - begin) / (falls - begin);
    const [x, y] = at.map((from, i) => from + share * (to[i] - from));
    return { x, y, paint: PART_PAINTS[part.split(" ")[0]] ?? PART_PAINTS.orange };
  });
}

/** Metres. The arrow through a one-way gate, and its head. */
const ARROW = 1.2, HEAD = 0.35;

/** Zones as dashed outlines, forbidden ones in the colour of danger; gates as dotted lines with arrows. */
function drawRules(pen, { zones = [], gates = [] }) {
  drawZones(pen, zones);
  for (const gate of gates) drawGate(pen, gate);
}

function drawGate({ context, camera, palette }, { ends: [[ax, ay], [bx, by]], direction: [dx, dy] }) {
  const [x, y] = [(ax + bx) / 2, (ay + by) / 2];
  const at = (along, beside) => [x + along * dx - beside * dy, y + along * dy + beside * dx];
  context.strokeStyle = palette["person-2"];
  context.lineWidth = 1.5;
  context.setLineDash([2, 3]);
  strokePath(context, camera, [[ax, ay], [bx, by]]);
  context.setLineDash([]);
  const tip = ARROW / 2, neck = tip - HEAD;
  strokePath(context, camera, [at(-tip, 0), at(tip, 0)]);
  strokePath(context, camera, [at(neck, HEAD / 2), at(tip, 0), at(neck, -HEAD / 2)]);
}

function drawZones({ context, camera, palette }, zones) {
  context.lineWidth = 1.25;
  for (const { footprint, forbidden } of zones) {
    context.strokeStyle = context.fillStyle = palette[forbidden ? "danger" : "muted"];
    outline(context, camera, footprint);
    alpha(context, 0.08, () => context.fill());
    context.setLineDash([6, 4]);
    context.stroke();
    context.setLineDash([]);
  }
}

/** Zones and gates, and what is there at t. */
function drawPassing({ context, camera, palette }, run, t) {
  drawRules({ context, camera, palette }, run.plan);
  for (const { footprint } of thereAt(run, t)) {
    context.fillStyle = palette.high;
    context.strokeStyle = palette.text;
    outline(context, camera, footprint);
    context.fill();
    context.stroke();
  }
  for (const { x, y, paint } of conveyedAt(run, t)) {
    const half = partSize(camera.scale) / 2;
    context.fillStyle = paint;
    context.strokeStyle = palette.halo;
    context.lineWidth = 1;
    outline(context, camera, [[x - half, y - half], [x + half, y - half], [x + half, y + half], [x - half, y + half]]);
    context.fill();
    context.stroke();
  }
}
