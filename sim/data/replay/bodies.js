/* People, AGVs and the gantry as they are drawn at an instant. */

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

/** An AGV: its footprint, with a mark where it is ahead. */
function drawAgv({ context, camera, palette }, agv, t) {
  const { x, y, rotation } = agv.motion.at(t);
  const [length, width] = [agv.length * camera.scale, agv.width * camera.scale];
  context.save();
  context.translate(...camera.toScreen(x, y));
  context.rotate(-rotation);
  context.beginPath();
  context.roundRect(-length / 2, -width / 2, length, width, Math.min(4, width / 4));
  context.fillStyle = palette[agv.color];
  context.fill();
  context.lineWidth = 1;
  context.strokeStyle = palette.halo;
  context.stroke();
  context.lineWidth = Math.max(1.5, width / 12);
  context.beginPath();                   // which way is ahead
  context.moveTo(length * 0.36, -width * 0.2);
  context.lineTo(length * 0.44, 0);
  context.lineTo(length * 0.36, width * 0.2);
  context.stroke();
  context.restore();
}

/** The gantry: its bridge across the floor, the torso on it, and the arm with its reach. */
function drawGantry(pen, gantry, t, span, disabled) {
  const { x, y, rotation } = gantry.motion.at(t);
  if (span) drawBridge(pen, x, span);
  const { context, camera } = pen;
  context.save();
  context.translate(...camera.toScreen(x, y));
  context.rotate(-rotation);
  drawReach(pen, gantry);
  drawTorso(pen, gantry, disabled);
  drawArm(pen, gantry);
  context.restore();
}

function drawBridge({ context, camera, palette }, x, span) {
  const half = Math.max(3, 0.2 * camera.scale);
  const [px, low] = camera.toScreen(x, span.y[0]);
  const [, high] = camera.toScreen(x, span.y[1]);
  const box = [px - half, high - half, 2 * half, low - high + 2 * half];
  context.strokeStyle = context.fillStyle = palette.gantry;
  context.lineWidth = 1.5;
  alpha(context, 0.8, () => context.strokeRect(...box));
  alpha(context, 0.12, () => context.fillRect(...box));
}

/** How far the folded arm reaches, whichever way the torso turns. */
function drawReach({ context, camera, palette }, { reach }) {
  context.strokeStyle = palette.gantry;
  context.lineWidth = 1.25;
  context.setLineDash([3, 3]);
  context.beginPath();
  context.arc(0, 0, reach * camera.scale, 0, 2 * Math.PI);
  context.stroke();
  context.setLineDash([]);
}

function drawTorso({ context, camera, palette, hatch }, gantry, disabled) {
  const [length, width] = [gantry.length * camera.scale, gantry.width * camera.scale];
  context.beginPath();
  context.rect(-length / 2, -width / 2, length, width);
  alpha(context, 0.85, () => {
    context.fillStyle = disabled ? palette.low : palette.gantry;
    context.fill();
  });
  if (disabled) {
    context.fillStyle = hatch;
    context.fill();
  }
  context.lineWidth = 1.5;
  context.strokeStyle = palette["gantry-ink"];
  context.stroke();
}

/** The arm, from its mount to its reach. */
function drawArm({ context, camera, palette }, { mount, reach }) {
  context.strokeStyle = context.fillStyle = palette["gantry-ink"];
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
