/* People, vehicles and robots as they are drawn at an instant. */

/** A person: a disc with a nose, which is the heading. */
function drawPerson({ context, camera, palette }, person, t) {
  const { x, y } = person.motion.at(t);
  const [px, py] = camera.toScreen(x, y);
  const radius = Math.max(6, person.radius * camera.scale);
  context.save();
  context.translate(px, py);
  context.rotate(-person.motion.heading(t));
  context.beginPath();
  context.moveTo(radius * 1.75, 0);
  context.lineTo(radius * 0.7, radius * 0.7);
  context.lineTo(radius * 0.7, -radius * 0.7);
  context.closePath();
  context.moveTo(radius, 0);
  context.arc(0, 0, radius, 0, 2 * Math.PI);
  context.lineWidth = 3;
  context.strokeStyle = palette.halo;
  context.stroke();
  context.fillStyle = palette[person.color];
  context.fill();
  context.restore();
}

/** A vehicle: its footprint, with a mark at its front. */
function drawVehicle({ context, camera, palette }, vehicle, t) {
  const { x, y, rotation } = vehicle.motion.at(t);
  const [length, width] = [vehicle.length * camera.scale, vehicle.width * camera.scale];
  context.save();
  context.translate(...camera.toScreen(x, y));
  context.rotate(-rotation);
  context.beginPath();
  if (vehicle.outline) {
    for (const [ahead, left] of vehicle.outline) context.lineTo(ahead * camera.scale, -left * camera.scale);
    context.closePath();
  } else {
    context.roundRect(-length / 2, -width / 2, length, width, Math.min(4, width / 4));
  }
  context.fillStyle = palette[vehicle.color];
  context.fill();
  context.lineWidth = 1;
  context.strokeStyle = palette.halo;
  context.stroke();
  context.lineWidth = Math.max(1.5, width / 12);
  context.beginPath();                   // the front
  context.moveTo(length * 0.36, -width * 0.2);
  context.lineTo(length * 0.44, 0);
  context.lineTo(length * 0.36, width * 0.2);
  context.stroke();
  context.restore();
}

/** A robot: its bridge across the floor, if it rides on one, its box, and its arm, if it has one. */
function drawRobot(pen, robot, t, disabled) {
  const { x, y, rotation } = robot.motion.at(t);
  if (robot.bridge) drawBridge(pen, x, robot.bridge);
  const { context, camera } = pen;
  context.save();
  context.translate(...camera.toScreen(x, y));
  context.rotate(-rotation);
  if (robot.reach) drawReach(pen, robot);
  drawBox(pen, robot, disabled);
  if (robot.reach) drawArm(pen, robot);
  context.restore();
}

function drawBridge({ context, camera, palette }, x, [low, high]) {
  const half = Math.max(3, 0.2 * camera.scale);
  const [px, south] = camera.toScreen(x, low);
  const [, north] = camera.toScreen(x, high);
  const box = [px - half, north - half, 2 * half, south - north + 2 * half];
  context.strokeStyle = context.fillStyle = palette.robot;
  context.lineWidth = 1.5;
  alpha(context, 0.8, () => context.strokeRect(...box));
  alpha(context, 0.12, () => context.fillRect(...box));
}

/** The circle that the folded arm stays within, however the robot turns. */
function drawReach({ context, camera, palette }, { reach }) {
  context.strokeStyle = palette.robot;
  context.lineWidth = 1.25;
  context.setLineDash([3, 3]);
  context.beginPath();
  context.arc(0, 0, reach * camera.scale, 0, 2 * Math.PI);
  context.stroke();
  context.setLineDash([]);
}

function drawBox({ context, camera, palette, hatch }, robot, disabled) {
  const [length, width] = [robot.length * camera.scale, robot.width * camera.scale];
  context.beginPath();
  context.rect(-length / 2, -width / 2, length, width);
  alpha(context, 0.85, () => {
    context.fillStyle = disabled ? palette.low : palette.robot;
    context.fill();
  });
  if (disabled) {
    context.fillStyle = hatch;
    context.fill();
  }
  context.lineWidth = 1.5;
  context.strokeStyle = palette["robot-ink"];
  context.stroke();
}

/** The arm, from its mount to its reach. */
function drawArm({ context, camera, palette }, { mount, reach }) {
  context.strokeStyle = context.fillStyle = palette["robot-ink"];
  context.lineWidth = Math.max(2.5, 0.14 * camera.scale);
  context.lineCap = "round";
  context.beginPath();
  context.moveTo(mount * camera.scale, 0);
  context.lineTo(reach * camera.scale, 0);
  context.stroke();
  context.beginPath();
  context.arc(mount * camera.scale, 0, Math.max(2.5, 0.13 * camera.scale), 0, 2 * Math.PI);
  context.fill();
}
