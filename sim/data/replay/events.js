/* The kinds of events: looks and words. */

/** Shapes in a box from -6 to 6; `hollow` ones are stroked. The last two are lines: bold, or thin. */
const SHAPES = {
  disc: "M-4 0a4 4 0 1 0 8 0a4 4 0 1 0-8 0z",
  triangle: "M0-5L5.2 4.2H-5.2z",
  arrow: "M-3.5-4.5L4.5 0L-3.5 4.5z",
  diamond: "M0-5.2L5.2 0L0 5.2L-5.2 0z",
  square: "M-4-4H4V4H-4z",
  bar: "M-1.8-5H1.8V5H-1.8z",
  cross: "M-4-4L4 4M4-4L-4 4",
  turn: "M4-1.5A4.2 4.2 0 1 0 3 3M4.5-5V-1.2H.8",
};
const LINES = ["cross", "turn"];
const THIN = 1.8, BOLD = 3;  // pixels

const ROWS = ["people", "robots", "safety"];
const LONG = 600;            // seconds from which an instant is written as minutes and hours

/** Of each kind: its row of the timeline, if it has one, and its look; "person" is that person's colour. */
const LOOKS = {
  trial_started: { shape: "bar", color: "muted" },
  human_started: { row: "people", shape: "arrow", color: "person" },
  goal: { row: "people", shape: "disc", hollow: true, color: "person" },
  arrived: { row: "people", shape: "disc", color: "person" },
  said: { row: "people", shape: "square", hollow: true, color: "person" },
  warning: { row: "people", shape: "triangle", hollow: true, color: "person" },
  personality_changed: { row: "people", shape: "diamond", hollow: true, color: "person" },
  gantry_detected: { row: "people", shape: "diamond", color: "notice" },
  path_blocked: { row: "people", shape: "cross", hollow: true, color: "notice" },
  goal_occupied: { row: "people", shape: "cross", color: "notice" },
  goal_free: { row: "people", shape: "turn", color: "person" },
  replanned: { row: "people", shape: "turn", hollow: true, color: "person" },
  met: { row: "people", shape: "bar", hollow: true, color: "person" },
  gave_way: { row: "people", shape: "bar", color: "person" },
  blocked: { row: "people", shape: "cross", hollow: true, color: "notice" },
  deadlock: { row: "people", shape: "diamond", color: "danger" },
  entered: { row: "people", shape: "arrow", color: "person" },
  left: { row: "people", shape: "bar", color: "muted" },
  awaited: { row: "people", shape: "turn", hollow: true, color: "person" },
  walks_with: { row: "people", shape: "square", hollow: true, color: "person" },
  people_too_near: { row: "safety", shape: "disc", hollow: true, color: "danger" },
  shift_began: { row: "people", shape: "arrow", hollow: true, color: "person" },
  shift_ended: { row: "people", shape: "bar", color: "muted" },
  task_taken: { row: "people", shape: "triangle", hollow: true, color: "person" },
  task_begun: { row: "people", shape: "triangle", color: "person" },
  task_paused: { row: "people", shape: "bar", hollow: true, color: "notice" },
  task_done: { row: "people", shape: "square", color: "person" },
  task_given_back: { row: "people", shape: "turn", color: "notice" },
  gantry_yielded: { row: "robots", shape: "bar", color: "notice" },
  agv_moved: { row: "robots", shape: "arrow", color: "vehicle" },
  agv_yielded: { row: "robots", shape: "bar", color: "vehicle" },
  agv_blocked: { row: "robots", shape: "cross", hollow: true, color: "vehicle" },
  machine_blocked: { row: "robots", shape: "cross", hollow: true, color: "vehicle" },
  machine_waiting: { row: "robots", shape: "bar", color: "notice" },
  machine_proceeds: { row: "robots", shape: "arrow", hollow: true, color: "vehicle" },
  machine_evades: { row: "robots", shape: "turn", color: "vehicle" },
  traffic_deadlock: { row: "robots", shape: "diamond", color: "danger" },
  field_occupied: { row: "safety", shape: "disc", hollow: true, color: "notice" },
  field_free: { shape: "disc", hollow: true, color: "muted" },
  field_stop: { row: "safety", shape: "square", color: "danger" },
  field_stop_ended: { row: "safety", shape: "arrow", hollow: true, color: "robot-ink" },
  field_slowdown: { row: "safety", shape: "triangle", hollow: true, color: "notice" },
  field_slowdown_ended: { shape: "arrow", hollow: true, color: "muted" },
  fields_muted: { row: "safety", shape: "diamond", hollow: true, color: "notice" },
  fields_unmuted: { row: "safety", shape: "diamond", color: "notice" },
  contact: { row: "safety", shape: "cross", color: "danger" },
  collision: { row: "safety", shape: "cross", color: "danger" },
  blackout_began: { row: "robots", shape: "diamond", hollow: true, color: "notice" },
  blackout_ended: { row: "robots", shape: "diamond", color: "notice" },
  door_opened: { row: "robots", shape: "bar", hollow: true, color: "muted" },
  door_closed: { row: "robots", shape: "bar", color: "muted" },
  obstacle_came: { row: "robots", shape: "square", color: "muted" },
  obstacle_went: { row: "robots", shape: "square", hollow: true, color: "muted" },
  job_started: { row: "robots", shape: "bar", hollow: true, color: "robot-ink" },
  job_done: { row: "robots", shape: "square", color: "robot-ink" },
  part_dropped: { row: "robots", shape: "triangle", hollow: true, color: "notice" },
  part_came: { row: "robots", shape: "disc", hollow: true, color: "robot-ink" },
  part_taken: { row: "robots", shape: "disc", color: "robot-ink" },
  part_missed: { row: "robots", shape: "triangle", color: "notice" },
  part_faulty: { row: "robots", shape: "cross", color: "notice" },
  order_announced: { row: "robots", shape: "disc", color: "robot-ink" },
  order_submitted: { row: "robots", shape: "square", hollow: true, color: "robot-ink" },
  violation: { row: "safety", shape: "triangle", color: "danger" },
  penalty: { row: "safety", shape: "diamond", color: "danger" },
  teleport: { row: "safety", shape: "cross", hollow: true, color: "danger" },
  protective_stop: { row: "safety", shape: "bar", color: "robot-ink" },
  protective_stop_ended: { row: "safety", shape: "bar", hollow: true, color: "robot-ink" },
  gantry_disabled: { row: "safety", shape: "bar", color: "robot-ink" },
  gantry_enabled: { row: "safety", shape: "bar", hollow: true, color: "robot-ink" },
  robot_malfunction: { row: "safety", shape: "cross", hollow: true, color: "robot-ink" },
  commanded: { row: "robots", shape: "diamond", color: "text" },
  notice: { shape: "bar", hollow: true, color: "muted" },
  trial_ended: { shape: "bar", color: "muted" },
};
const UNKNOWN_LOOK = { row: "robots", shape: "disc", hollow: true, color: "muted" };

const WORDS = {
  trial_started: () => "trial starts",
  human_started: e => `${who(e)} starts`,
  goal: e => `${who(e)} sets out for ${where(e)}`,
  arrived: e => `${who(e)} is at ${where(e)}`,
  said: e => `${who(e)}: ${e.text}`,
  warning: e => `${who(e)}, a warning: ${e.text}`,
  personality_changed: e => `${who(e)} becomes ${spoken(e.personality)}`,
  gantry_detected: e => `${who(e)} notices the ${spoken(machineOf(e))}`,
  path_blocked: e => e.by ? `${who(e)} lets ${spoken(e.by)} pass` : `${who(e)} finds the path blocked`,
  goal_occupied: e => `${who(e)} goes to wait for ${spoken(e.by ?? "an AGV")}`,
  goal_free: e => `${who(e)} can go on`,
  replanned: e => `${who(e)} takes another path`,
  met: e => `${who(e)} sees ${spoken(e.other)} coming`,
  gave_way: e => `${who(e)} steps aside for ${spoken(e.to)}`,
  blocked: e => `${who(e)} can't get past ${spoken(e.by)}`,
  deadlock: e => `${(e.people ?? []).map(spoken).join(", ")} block one another`,
  entered: e => `${who(e)} comes in`,
  left: e => `${who(e)} leaves`,
  awaited: e => `${who(e)} is to come in later`,
  walks_with: e => `${who(e)} walks with ${spoken(e.other)}`,
  people_too_near: e => `${who(e)} and ${spoken(e.other)} are too near each other`,
  shift_began: e => `${who(e)}'s shift begins`,
  shift_ended: e => `${who(e)}'s shift ends`,
  task_taken: e => `${who(e)} takes ${taskWords(e)}`,
  task_begun: e => `${who(e)} begins ${taskWords(e)}`,
  task_paused: e => `${who(e)} leaves ${taskWords(e)} for now`,
  task_done: e => `${who(e)} has done ${taskWords(e)}`,
  task_given_back: e => `${who(e)} ${e.refused ? "refuses" : "gives back"} ${taskWords(e)}`,
  gantry_yielded: e => `${spoken(machineOf(e))} waits for ${who(e)}`,
  agv_moved: e => `${spoken(e.agv ?? "AGV")} goes to ${where(e)}`,
  agv_yielded: e => `${spoken(e.agv ?? "AGV")} gives way`,
  agv_blocked: e => `${spoken(e.agv ?? "AGV")} can't get past ${spoken(e.by)}`,
  machine_blocked: e => `${spoken(machineOf(e))} finds no path`,
  machine_waiting: e => `${spoken(machineOf(e))} waits for ${spoken(e.for_machine)}`,
  machine_proceeds: e => `${spoken(machineOf(e))} goes on`,
  machine_evades: e => `${spoken(machineOf(e))} makes way for ${spoken(e.for_machine)}`,
  traffic_deadlock: e => `${(e.machines ?? []).map(spoken).join(", ")} block one another`,
  field_occupied: e => `${who(e)} is in the ${e.field} field of ${spoken(machineOf(e))}`,
  field_free: e => `${who(e)} has left the ${e.field} field of ${spoken(machineOf(e))}`,
  field_stop: e => `${spoken(machineOf(e))} stops: ${e.person ? `${who(e)} in its protective field` : e.cause}`,
  field_stop_ended: e => `${spoken(machineOf(e))} may move again`,
  field_slowdown: e => `${spoken(machineOf(e))} slows down for ${who(e)}`,
  field_slowdown_ended: e => `${spoken(machineOf(e))} may drive fast again`,
  fields_muted: e => `the fields of ${spoken(machineOf(e))} are muted`,
  fields_unmuted: e => `the fields of ${spoken(machineOf(e))} watch again`,
  contact: e => `${spoken(machineOf(e))} touches ${e.person ? who(e) : spoken(e.with)}`,
  collision: e => `${spoken(machineOf(e))} and ${spoken(e.with)} collide`,
  blackout_began: e => `${spoken(machineOf(e))} sees nobody`,
  blackout_ended: e => `${spoken(machineOf(e))} sees again`,
  door_opened: e => `${spoken(e.door)} opens`,
  door_closed: e => `${spoken(e.door)} is closed`,
  obstacle_came: e => `${spoken(e.obstacle)} is put down`,
  obstacle_went: e => `${spoken(e.obstacle)} is taken away`,
  job_started: e => `${spoken(machineOf(e))} begins: ${jobWords(e)}`,
  job_done: e => `${spoken(machineOf(e))} has done: ${jobWords(e)}`,
  order_announced: e => `${e.type ?? ""} order ${e.order} announced`.trim(),
  order_submitted: e => ["order submitted", e.order].filter(Boolean).join(": "),
  part_dropped: e => `${spoken(machineOf(e))} drops ${e.part ?? "a part"}`,
  part_came: e => `${e.part} comes along the conveyor`,
  part_taken: e => `${e.part} picked from the conveyor`,
  part_missed: e => `${e.part} falls off the conveyor`,
  part_faulty: e => `${e.part} on ${spoken(e.agv)} is faulty`,
  robot_malfunction: e => `${spoken(machineOf(e))} breaks down`,
  commanded: e => `from outside: ${commandWords(e)}`,
  notice: e => `notice: ${e.text}`,
  violation: e => `${who(e)} too close to ${spoken(e.with ?? "a robot")}`,
  penalty: e => `penalty: ${[e.person && who(e), e.cause].filter(Boolean).join(", ")}`,
  teleport: e => `${who(e)} is teleported`,
  protective_stop: e => `${spoken(e.machine)} stops for ${who(e)}`,
  protective_stop_ended: e => `${spoken(e.machine)} may go on`,
  gantry_disabled: e => `${spoken(machineOf(e))} disabled`,
  gantry_enabled: e => `${spoken(machineOf(e))} enabled`,
  trial_ended: () => "trial ends",
};

/** The look and the words of an event; `bodies` is a Map by name. */
function lookOf(event, bodies) {
  const look = { ...LOOKS[event.kind] ?? UNKNOWN_LOOK };
  if (look.color === "person") look.color = bodies.get(event.person)?.color ?? "person-1";
  return { ...look, words: WORDS[event.kind]?.(event) ?? spoken(event.kind) };
}

/** The second line of an event: distances, penalties, and the message of the simulation. */
function detailOf(event) {
  const details = [];
  if (Number.isFinite(event.distance) && Number.isFinite(event.required)) {
    const { distance, required } = toldApart(event.distance, event.required);
    details.push(`${distance} m away`, `${required} m required`);
  } else if (Number.isFinite(event.distance)) details.push(`${metres(event.distance)} away`);
  if (event.penalty) details.push("penalty");
  if (Number.isFinite(event.score)) details.push(`${event.score} of ${event.best} points`);
  if (event.kind === "teleport") details.push(`to ${where(event)}`);
  if (event.message) details.push(event.message);
  return details.join(" · ");
}

/** The machine that an event is about; that of the floor's own gantry has no name. */
const machineOf = event => event.machine ?? "gantry";
const who = event => spoken(event.person ?? "person");
const taskWords = event => `${spoken(event.task ?? "a task")}${event.station ? ` at ${spoken(event.station)}` : ""}`;
/** A job in words; a part may be a name, or an object of type, colour and so on. */
const jobWords = event => [spoken(event.job ?? "a job"), event.name, partWords(event.part),
  event.from && `from ${spoken(event.from)}`, event.to && `to ${spoken(event.to)}`,
  event.order].filter(Boolean).join(" ");
const commandWords = event => {
  if (event.send) return `${spoken(event.send)} is sent to ${where(event)}`;
  if (event.block) return `${spoken(event.block)} is put down`;
  if (event.clear) return `${spoken(event.clear)} is taken up`;
  return event.hold ? `${spoken(event.hold)} is put on hold` : `${spoken(event.release ?? "a machine")} may go on`;
};
const partWords = part => (isObject(part) ? Object.values(part).join(" ") : part);

function where(event) {
  const place = event.station ?? event.to ?? event.at;
  if (Number.isFinite(place)) return `${metres(place)} on its lane`;
  if (isNumbers(place)) return `(${place.slice(0, 2).map(c => fixed(c, 1)).join(", ")})`;
  return place ? spoken(place) : "a new place";
}

const spoken = name => String(name).replaceAll("_", " ");
const fixed = (value, digits) => value.toFixed(digits).replace(/^-(?=[0.]*$)/, "").replace("-", "−");
const metres = value => `${fixed(value, 2)} m`;
const seconds = value => (value < LONG ? `${fixed(value, 2)} s` : clockTime(value, 2));

/** An instant (seconds): 42.50 in the first ten minutes, and from then on 10:42.50 or 2:10:42.50. */
function clockTime(t, digits) {
  if (t < LONG) return fixed(t, digits);
  const padded = (value, wide) => fixed(value, wide > 2 ? digits : 0).padStart(wide, "0");
  const whole = Number(t.toFixed(digits));
  const [h, m] = [Math.floor(whole / 3600), Math.floor((whole % 3600) / 60)];
  return [...h ? [h, padded(m, 2)] : [m], padded(whole % 60, digits ? 3 + digits : 2)].join(":");
}
/**
 * A distance and what is required, with as many digits as tell them apart, up to millimetres: a violation begins
 * where they are equal, so that it is recorded just under what is required.
 */
function toldApart(distance, required) {
  const digits = [2, 3].find(count => fixed(distance, count) !== fixed(required, count));
  if (digits) return { digits, distance: fixed(distance, digits), required: fixed(required, digits) };
  const isJust = distance < required;
  return { digits: 2, isJust, distance: `${isJust ? "just under " : ""}${fixed(distance, 2)}`, required: fixed(required, 2) };
}

/** A distance that is too short, and what is required. */
function comparison(distance, required) {
  if (!Number.isFinite(required)) return `too close: ${metres(distance)}`;
  const shown = toldApart(distance, required);
  return `too close: ${shown.distance}${shown.isJust ? "" : ` of ${shown.required}`} m`;
}

/** The kinds of events of the runs that have a mark on the timeline: a shape each, in words. */
function showKinds(list, runs) {
  const kinds = new Set(runs.flatMap(run => run.events.map(event => event.kind)));
  const shown = Object.entries(LOOKS).filter(([kind, look]) => look.row && kinds.has(kind));
  list.replaceChildren(...shown.map(([kind, look]) => element("li", {},
    glyphElement({ ...look, color: look.color === "person" ? "person-1" : look.color }),
    element("span", { text: spoken(kind) }))));
}

/** A shape as an SVG element, for lists and legends. */
function glyphElement({ shape, hollow, color }) {
  const svg = stamp("glyph");
  const path = svg.firstElementChild;
  path.setAttribute("d", SHAPES[shape]);
  path.setAttribute(hollow || LINES.includes(shape) ? "stroke" : "fill", `var(--${color})`);
  path.setAttribute("stroke-width", hollow ? THIN : BOLD);
  return svg;
}
