/* Protective and warning fields of machines: the set that applies, as areas on the floor. */

const TOLERANCE = 1e-4;      // m/s and rad/s within which the limits of a set are met
const FIELD_HEIGHT = 8e-3;   // metres of a sheet over what is below, so that they do not flicker
const FIELD_KINDS = ["warning", "protective"];
const FIELD_COLORS = { warning: "notice", protective: "danger" };

/** The first set of a machine's fields that fits its velocity at t; undefined if none does, or they are muted. */
function fieldsAt(run, machine, t) {
  const { fields, motion } = machine;
  if (run.isMuted(machine, t)) return undefined;
  const { rotation, vx, vy, turning, speed } = motion.at(t);
  const along = vx * Math.cos(rotation) + vy * Math.sin(rotation);
  const isIn = (value, [low, high]) => value >= (low ?? -Infinity) - TOLERANCE && value <= (high ?? Infinity) + TOLERANCE;
  return fields.find(({ linear = [], theta = [], direction }) => isIn(direction ? speed : along, linear) && isIn(turning, theta)
    && (!direction || speed <= TOLERANCE || isIn(angleFrom(direction[0], Math.atan2(vy, vx) - rotation), [0, direction[1] - direction[0]])));
}

/** The angle from one direction counterclockwise to another, 0 to 2π. */
const angleFrom = (from, to) => (((to - from) % (2 * Math.PI)) + 2 * Math.PI) % (2 * Math.PI);

/** The corners of a field of a machine on the floor at t. */
function onFloor(corners, { motion }, t) {
  const { x, y, rotation } = motion.at(t);
  const [c, s] = [Math.cos(rotation), Math.sin(rotation)];
  return corners.map(([ahead, left]) => [x + c * ahead - s * left, y + s * ahead + c * left]);
}

/** The fields of a machine, stronger while somebody is in them. */
function drawFields({ context, camera, palette }, run, machine, t) {
  const set = fieldsAt(run, machine, t);
  if (!set) return;
  for (const kind of FIELD_KINDS) {
    if (!set[kind]?.length) continue;
    const isOccupied = run.isOccupied(machine, kind, t);
    context.fillStyle = context.strokeStyle = palette[FIELD_COLORS[kind]];
    outline(context, camera, onFloor(set[kind], machine, t));
    alpha(context, isOccupied ? 0.3 : 0.1, () => context.fill());
    context.lineWidth = isOccupied ? 2 : 1;
    context.setLineDash(kind === "warning" ? [5, 4] : []);
    alpha(context, 0.8, () => context.stroke());
    context.setLineDash([]);
  }
}

/** The same in three dimensions: sheets over the floor, under the machine. */
function addFields(pile, renderer, run, machine, t, colors) {
  const set = fieldsAt(run, machine, t);
  const { x, y, rotation } = machine.motion.at(t);
  FIELD_KINDS.forEach((kind, i) => {
    if (!set?.[kind]?.length) return;
    const shape = renderer.learned(set[kind], () => prismMesh(set[kind], 0, 1e-3));
    const opacity = run.isOccupied(machine, kind, t) ? 0.5 : 0.2;
    pile.add(shape, "glow", frameAt(x, y, FIELD_HEIGHT * (i + 1), rotation), colors[FIELD_COLORS[kind]], opacity);
  });
}
