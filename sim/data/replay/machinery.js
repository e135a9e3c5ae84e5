/* Machines in three dimensions: the gantry on its rails, vehicles, other robots. */

const RAIL_HEIGHT = 2.9;     // metres, where a recording does not say
const HANGER = 1.3;          // metres of the rods on which rails hang

/** The rails of a gantry, which do not move; they hang, so that nothing stands on the floor. */
function addRails(pile, { x: [low, high], y, rail_height: height = RAIL_HEIGHT }, colors) {
  const length = high - low + 0.8;
  const rods = Math.max(2, Math.ceil(length / 4) + 1);
  for (const side of y) {
    const middle = frameAt((low + high) / 2, side, height);
    pile.add("box", "edged", sized(shifted(middle, 0, 0, 0.02), length, 0.16, 0.05), colors.steel);
    pile.add("box", "edged", sized(shifted(middle, 0, 0, -0.1), length, 0.06, 0.12), colors.steel);
    for (let i = 0; i < rods; i++) {
      const place = frameAt(low - 0.2 + ((high - low + 0.4) * i) / (rods - 1), side, height + 0.07);
      pile.add("tube", "glow", sized(place, 0.05, 0.05, HANGER), colors.steel, 0.9);
    }
  }
}

/** A robot: under its bridge, if it rides on one, with its arm, if it has one. */
function addRobot(pile, robot, t, isDisabled, colors) {
  const { x, y, rotation } = robot.motion.at(t);
  const [bottom, top] = [bottomOf(robot), heightOf(robot)];
  const paint = isDisabled ? mixed(colors.high, colors.low, 0.4) : colors.robot;
  const put = (shape, frame, l, w, h, own = paint) => pile.add(
    shape, shape === "box" ? "edged" : "solid", sized(frame, l, w, h), own);
  if (robot.bridge) {
    const [low, high] = robot.bridge;
    const rail = robot.rail_height ?? RAIL_HEIGHT;
    const beam = frameAt(x, (low + high) / 2, rail + 0.07);
    for (const side of [-0.22, 0.22]) put("box", shifted(beam, side, 0, 0.1), 0.12, high - low + 0.3, 0.26, paint);
    for (const end of [low, high]) put("box", frameAt(x, end, rail + 0.07), 0.95, 0.3, 0.14, colors.steel);
    put("box", frameAt(x, y, rail + 0.1), 0.75, 0.7, 0.36, colors.steel);
    put("cylinder", frameAt(x, y, top - 0.01), 0.46, 0.46, Math.max(0.05, rail + 0.15 - top), colors.steel);
  }
  const body = frameAt(x, y, bottom, rotation);
  const height = top - bottom;
  put("box", shifted(body, 0, 0, 0.12 * height), robot.length, robot.width, 0.88 * height);
  put("box", body, 0.8 * robot.length, 0.8 * robot.width, 0.12 * height, colors.ink);
  put("box", shifted(body, robot.length / 2, 0, 0.62 * height), 0.03, 0.6 * robot.width, 0.1 * height, colors.ink);
  put("cylinder", shifted(body, -0.3 * robot.length, 0.3 * robot.width, height), 0.1, 0.1, 0.09,
    isDisabled ? colors.danger : colors["person-2"]);
  if (robot.reach) addArm(put, robot, body, bottom, colors);
}

/** The folded arm: from its shoulder out and down to its tool, within its reach. */
function addArm(put, robot, body, bottom, colors) {
  const shoulderHeight = (robot.shoulder ?? bottom + 0.75) - bottom;
  const lowest = (robot.arm_bottom ?? bottom - 0.14) - bottom;
  const shoulder = shifted(body, robot.mount, 0, shoulderHeight);
  const out = Math.max(0.1, robot.reach - robot.mount - 0.1);
  put("ball", shoulder, 0.26, 0.3, 0.26, colors.ink);
  const tool = shifted(body, robot.mount + out, 0, lowest + 0.14);
  const elbow = shifted(body, robot.mount + 0.55 * out, 0, shoulderHeight + 0.22);
  addRod(put, shoulder, elbow, 0.15, colors.arm);
  put("ball", elbow, 0.19, 0.22, 0.19, colors.ink);
  addRod(put, elbow, tool, 0.12, colors.arm);
  put("ball", tool, 0.14, 0.16, 0.14, colors.ink);
  put("cylinder", shifted(tool, 0, 0, -0.14), 0.11, 0.11, 0.1, colors.steel);
}

/** A rod from the origin of one frame to that of another. */
function addRod(put, from, to, width, color) {
  const axis = [from[9] - to[9], from[10] - to[10], from[11] - to[11]];
  const length = Math.hypot(...axis);
  const up = unit(axis);
  const side = unit(cross(up, Math.abs(up[2]) < 0.99 ? [0, 0, 1] : [1, 0, 0]));
  put("limb", [...side, ...cross(up, side), ...up, from[9], from[10], from[11]], width, width, length, color);
}

/** A vehicle: a low body on wheels, and what it carries its load on. */
function addVehicle(pile, renderer, vehicle, t, colors) {
  const { x, y, rotation } = vehicle.motion.at(t);
  const { length, width } = vehicle;
  const bottom = bottomOf(vehicle);
  const height = Math.max(0.2, heightOf(vehicle) - bottom);
  const body = frameAt(x, y, bottom, rotation);
  const put = (shape, frame, l, w, h, own) => pile.add(shape, shape === "box" ? "edged" : "solid", sized(frame, l, w, h), own);
  if (vehicle.outline) {
    const prism = renderer.learned(vehicle, () => prismMesh(vehicle.outline, 0, 1));
    pile.add(prism, "edged", sized(body, 1, 1, height), colors.vehicle);
    put("box", shifted(body, 0.3 * length, 0, height), 0.1 * length, 0.1 * width, 0.02, colors.stripe);
    return;
  }
  const chassis = Math.min(0.36, 0.5 * height);
  for (const end of [-1, 1]) {
    for (const side of [-1, 1]) {
      const wheel = leaned(shifted(body, end * 0.34 * length, side * (width / 2 - 0.02), 0.08), Math.PI / 2);
      put("cylinder", shifted(wheel, 0, 0, -0.03), 0.16, 0.16, 0.06, colors.ink);
    }
  }
  put("box", shifted(body, 0, 0, 0.05), length, width - 0.08, chassis - 0.05, colors.vehicle);
  put("box", shifted(body, length / 2 - 0.01, 0, 0.55 * chassis), 0.03, 0.7 * width, 0.06, colors.stripe);
  put("box", shifted(body, -length / 2 + 0.01, 0, 0.55 * chassis), 0.03, 0.7 * width, 0.06, colors.danger);
  if (height > 0.6) {
    for (const end of [-1, 1]) {
      put("box", shifted(body, end * 0.36 * length, 0, chassis), 0.1, 0.55 * width, height - chassis - 0.06, colors.steel);
    }
    put("box", shifted(body, 0, 0, height - 0.06), length, width, 0.06, mixed(colors.vehicle, colors.stripe, 0.45));
  }
}
