/* Words and marks over the view in three dimensions. */

const FAR_NAMES = 16;        // CSS pixels a metre from which furniture has its names
const NEAR_NAMES = 60;       // the same of walls
const EDGE = 14;             // CSS pixels from the edge of the screen to the mark of who is outside

/** Writes names, figures and violations where they are seen; `tools` are {context, eye, palette, world}. */
function drawMarks(tools, run, t, chosen, afterglow, hidden) {
  const pen = { ...tools, camera: tools.eye, taken: [] };
  drawViolationMarks(pen, run, t);
  const there = tools.world.bodiesAt(t, tools.eye);
  const shown = run.shown(chosen, t).filter(watch => there.includes(watch.person) && there.includes(watch.other));
  const bodies = there.filter(body => body !== hidden);
  const order = ["person", "robot", "vehicle"];
  bodies.sort((a, b) => order.indexOf(a.category) - order.indexOf(b.category));
  for (const body of bodies) takeBody(pen, body, t);
  const isWatched = body => body === chosen?.person || body === chosen?.other;
  for (const body of bodies) drawBodyName(pen, run, body, t, isWatched(body));
  const violated = run.watches.filter(watch => !shown.includes(watch) && watch.violatedAt(t));
  for (const watch of [...violated, ...shown]) drawFigure(pen, watch, t, watch === chosen);
  drawPlaceNames(pen, run);
}

/** Takes the place of a body, so that no name of another thing covers it. */
function takeBody({ eye, taken }, body, t) {
  const { x, y } = body.motion.at(t);
  const ends = [[x, y, bottomOf(body)], [x, y, heightOf(body)]].map(point => eye.toScreen(...point));
  if (ends.includes(null)) return;
  const [[ax, foot, away], [bx, head]] = ends;
  const wide = (0.25 * eye.height) / (2 * away * Math.tan(eye.field / 2));
  taken.push({ left: Math.min(ax, bx) - wide, right: Math.max(ax, bx) + wide, top: head, bottom: foot });
}

/** True if an obstacle that is not seen through stands between the eye and a point. */
function isCovered({ eye, world }, point) {
  return world.obstacles.some(({ top, solid }) => top >= HIDING && entryInto(solid, eye.position, point) < 0.999);
}

function drawBodyName(pen, run, body, t, isWatched) {
  const { context, eye, palette } = pen;
  const { x, y } = body.motion.at(t);
  const isPerson = body.category === "person";
  const top = heightOf(body) + (isPerson ? 0.1 : 0);
  const place = eye.toScreen(x, y, top);
  const name = nameNow(run, body, t);
  const color = palette[body.category === "robot" ? "robot-ink" : isPerson ? body.color : "muted"];
  const look = { size: isPerson || body.category === "robot" ? 13 : 11, weight: 600, color, halo: palette.halo };
  const wide = textWidth(context, name, look);
  if (!place || place[0] < 0 || place[0] > eye.width || place[1] < 0 || place[1] > eye.height) {
    if (isWatched) drawOutside(pen, name, [x, y, 1], wide, look);
    return;
  }
  const py = place[1];
  const px = Math.min(Math.max(place[0], wide / 2 + 4), eye.width - wide / 2 - 4);
  const places = [[px, py - 11], [px, py - 25], [px + wide / 2 + 16, py], [px - wide / 2 - 16, py], [px, py + 18]];
  const at = takePlace(pen, places, wide, look.size + 3);
  alpha(context, isCovered(pen, [x, y, top]) ? 0.55 : 1, () => drawText(context, name, ...at, look));
}

/** Who is not on the screen: the name at its edge, and an arrow that points there. */
function drawOutside(pen, name, point, wide, look) {
  const { context, eye } = pen;
  const [x, y, , w] = transformed(eye.matrix, point);
  const [dx, dy] = w > 0 ? [x, -y] : [-x, y + 1e-6];
  const [middle, level] = [eye.width / 2, eye.height / 2];
  const reach = Math.min((middle - EDGE) / Math.max(Math.abs(dx * middle), 1e-9),
    (level - EDGE) / Math.max(Math.abs(dy * level), 1e-9));
  const [px, py] = [middle + dx * middle * reach, level + dy * level * reach];
  context.save();
  context.translate(px, py);
  context.rotate(Math.atan2(py - level, px - middle));
  context.beginPath();
  context.moveTo(8, 0);
  context.lineTo(-5, 6);
  context.lineTo(-5, -6);
  context.closePath();
  context.fillStyle = look.color;
  context.strokeStyle = look.halo;
  context.lineWidth = 3;
  context.stroke();
  context.fill();
  context.restore();
  const tx = Math.min(Math.max(px, wide / 2 + 8), eye.width - wide / 2 - 8);
  const ty = py < level ? py + 20 : py - 20;
  drawText(context, name, ...takePlace(pen, [[tx, ty]], wide, look.size + 3), look);
}

/** The distance of a pair, on the line between them, where it matters now. */
function drawFigure(pen, watch, t, isChosen) {
  const { context, eye, palette } = pen;
  const { distance, required, notice, violated } = watch.at(t);
  if (!isChosen && !violated && !(notice !== null && distance < notice)) return;
  const [from, to] = [watch.person, watch.other].map(body => body.motion.at(t));
  const seen = [0.5, 0.35, 0.65, 0.2, 0.8].map(share => eye.toScreen(
    from.x + share * (to.x - from.x), from.y + share * (to.y - from.y), 0)).filter(Boolean);
  if (!seen.length) return;
  const text = violated ? comparison(distance, required) : metres(distance);
  const aside = seen.flatMap(([x, y]) => [[x, y - 26], [x, y + 26]]);
  const place = takePlace(pen, [...seen, ...aside], plateWidth(context, text), 20, isChosen ? Infinity : COVERING);
  if (place) drawPlate(context, text, ...place, palette, violated ? "danger-ink" : "text");
}

/** The violations so far, the latest of many: a mark each. */
function drawViolationMarks(pen, run, t) {
  const { context, eye, palette } = pen;
  const last = lastUpTo(run.violationTimes, t);
  for (let i = Math.max(0, last + 1 - MOST_MARKS); i <= last; i++) {
    const { person } = run.violations[i];
    const place = eye.toScreen(person.x, person.y, 0.05);
    if (!place) continue;
    alpha(context, isCovered(pen, [person.x, person.y, 0.05]) ? 0.4 : 1, () => {
      drawGlyph(context, LOOKS.violation, place[0], place[1], palette, 1.5);
      drawText(context, "!", place[0], place[1] + 1.5, { color: palette.halo, size: 9, weight: 700 });
    });
  }
}

/** The names of stations and safe zone, and of what stands near enough, where they cover nothing. */
function drawPlaceNames(pen, run) {
  const { context, eye, palette, world } = pen;
  const bold = { color: palette.text, halo: palette.halo, size: 12, weight: 600 };
  const plain = { color: palette.muted, halo: palette.halo, size: 11, weight: 400 };
  const write = (words, point, look, own) => {
    const place = eye.toScreen(...point);
    if (!place) return;
    const [px, py, away] = place;
    if (own && eye.height / (2 * away * Math.tan(eye.field / 2)) < (own.top < HIDING ? FAR_NAMES : NEAR_NAMES)) return;
    const wide = textWidth(context, words, look) / 2 + 3;
    const box = { left: px - wide, right: px + wide, top: py - 8, bottom: py + 8 };
    if (box.left < 0 || box.right > eye.width || box.top < 0 || box.bottom > eye.height) return;
    if (pen.taken.some(other => overlap(other, box))) return;
    if (world.obstacles.some(obstacle => obstacle !== own && entryInto(obstacle.solid, eye.position, point) < 0.999)) return;
    pen.taken.push(box);
    drawText(context, words, px, py, look);
  };
  for (const { name, at } of run.plan.stations) write(spoken(name), [...at, 0.03], bold);
  if (run.plan.safe_zone) write("safe zone", [...run.plan.safe_zone.at, 0.03], bold);
  const named = new Set();
  for (const obstacle of world.obstacles) {
    if (obstacle.bottom > 0) continue;
    const group = world.groups.find(({ members }) => members.some(member => member.name === obstacle.name));
    if (group && named.has(group)) continue;
    if (group) named.add(group);
    const box = group?.box ?? obstacle.solid.box;
    const middle = [(box.left + box.right) / 2, (box.bottom + box.top) / 2, obstacle.top + 0.02];
    write(group?.words ?? spoken(obstacle.name), middle, plain, obstacle);
  }
}
