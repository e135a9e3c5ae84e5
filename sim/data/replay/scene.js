/* All that moves, drawn over the floor: distances below, then bodies, then words and marks. */

const TRAIL = 12;            // seconds of the path behind that are shown
const TRAIL_GRAIN = 1;       // seconds of it that fade together
const AFTERGLOW = 2.5;       // seconds for which a violation and a teleport stay on the floor in full,
const GLIMPSE = 0.5;         // or, if that is longer, so many of the viewer's time
const FILMED = 1.5;          // the same of a film's time
const BODY_SIZE = 18;        // pixels round a body that no figure should cover
const CROWDED = 0.2;         // of a vehicle's name, from which it is left out where more is covered
const COVERING = 0.25;       // of a figure, from which it is left out where it covers more of others
const SLIGHT_COST = 1e-6;    // square pixels: rounding
const AWAY = 900;            // metres: so far only those jump who come in or leave
const MOST_MARKS = 20;       // of the violations so far, the latest are marked on the floor

/**
 * Draws `run` at t with `tools` ({context, camera, palette, hatch}, and the boxes of `names` that are there
 * already); `chosen` is the watch in focus.
 */
function drawScene(tools, run, t, chosen, afterglow) {
  const isHere = body => !isAway(body.motion.at(t), tools.camera);
  const bodies = [...run.bodies.values()].filter(isHere);
  const people = run.people.filter(isHere);
  const pen = {
    ...tools,
    taken: [...tools.names, ...bodies.map(body => boxRound(body.motion.at(t), BODY_SIZE, tools.camera))],
  };
  const ofCategory = category => bodies.filter(body => body.category === category);
  const shown = run.shown(chosen, t).filter(watch => isHere(watch.person) && isHere(watch.other));
  drawPassing(pen, run, t);
  for (const watch of shown) drawDistances(pen, watch, t);
  for (const body of bodies) if (body.fields) drawFields(pen, run, body, t);
  for (const body of bodies) drawTrail(pen, body, t);
  for (const vehicle of ofCategory("vehicle")) drawVehicle(pen, vehicle, t);
  drawWaits(pen, run, t);
  for (const person of people) drawPathAhead(pen, person, t);
  for (const robot of ofCategory("robot")) drawRobot(pen, robot, t, run.isDisabled(robot, t));
  for (const person of people) {
    drawTeleport(pen, person, t, afterglow);
    drawPerson(pen, person, t);
  }
  const named = [...people, ...ofCategory("robot"), ...ofCategory("vehicle")];
  drawViolations(pen, run, t, afterglow);
  for (const body of named) drawName(pen, run, body, t);
  const violated = run.watches.filter(watch => !shown.includes(watch) && watch.violatedAt(t));
  for (const watch of [...violated, ...shown]) drawSeparation(pen, watch, t, watch === chosen);
}

/** Whether somebody there is not on the floor: those who come later, or have left, are far outside. */
function isAway({ x, y }, { bounds: { left, right, bottom, top } }) {
  return x < left - AWAY || x > right + AWAY || y < bottom - AWAY || y > top + AWAY;
}

/** The protective distance as a disc round the person, the noticing distance as a fainter one. */
function drawDistances({ context, camera, palette, hatch }, watch, t) {
  const { x, y } = watch.person.motion.at(t);
  const [px, py] = camera.toScreen(x, y);
  const { required, notice, violated } = watch.at(t);
  const color = palette[violated ? "danger" : watch.person.color];
  const disc = (radius, opacity, style) => {
    context.beginPath();
    context.arc(px, py, (radius + watch.added) * camera.scale, 0, 2 * Math.PI);
    alpha(context, opacity, () => {
      context.fillStyle = style;
      context.fill();
    });
  };
  if (notice !== null) disc(notice, 0.04, palette[watch.person.color]);
  context.strokeStyle = color;
  context.lineWidth = 1;
  context.setLineDash([2, 4]);
  if (notice !== null) alpha(context, 0.6, () => context.stroke());
  context.setLineDash([]);
  disc(required, violated ? 0.2 : 0.1, color);
  if (violated) disc(required, 0.35, hatch);
  context.lineWidth = violated ? 2.5 : 1.25;
  alpha(context, 0.9, () => context.stroke());
}

function drawTrail({ context, camera, palette }, body, t) {
  context.strokeStyle = palette[body.color];
  context.lineWidth = body.category === "person" ? 3 : 2;
  body.track.behind(t, TRAIL, TRAIL_GRAIN, (points, age) => {
    alpha(context, 0.6 * (1 - age / TRAIL), () => strokePath(context, camera, points));
  });
}

function drawPathAhead({ context, camera, palette }, person, t) {
  const points = person.track.ahead(t);
  if (points.length < 2) return;
  context.strokeStyle = context.fillStyle = palette[person.color];
  context.lineWidth = 1.5;
  context.setLineDash([5, 4]);
  strokePath(context, camera, points);
  context.setLineDash([]);
  const [px, py] = camera.toScreen(...points.at(-1));
  context.beginPath();
  context.arc(px, py, 3, 0, 2 * Math.PI);
  context.fill();
}

/** A teleport: a thin line for a moment. */
function drawTeleport({ context, camera, palette }, person, t, afterglow) {
  const jump = person.motion.lastJump(t);
  if (!jump || t - jump.t > afterglow) return;
  if (Math.hypot(jump.to.x - jump.from.x, jump.to.y - jump.from.y) > AWAY) return;
  context.strokeStyle = palette[person.color];
  context.lineWidth = 1.25;
  context.setLineDash([1, 4]);
  alpha(context, 1 - 0.8 * ((t - jump.t) / afterglow), () => strokePath(
    context, camera, [[jump.from.x, jump.from.y], [jump.to.x, jump.to.y]]));
  context.setLineDash([]);
}

/** The line between two bodies, with their distance where that matters now. */
function drawSeparation(pen, watch, t, isChosen) {
  const { distance, required, notice, violated } = watch.at(t);
  const noticed = notice !== null && distance < notice;
  const figure = violated ? comparison(distance, required) : metres(distance);
  drawDistanceLine(pen, watch.person.motion.at(t), watch.other.motion.at(t), violated ? "danger" : "muted",
    violated || noticed, isChosen || violated || noticed ? figure : null, isChosen ? Infinity : COVERING);
}

/** A line between two places, with a text, if any, where it covers no more than a `share` of itself. */
function drawDistanceLine(pen, from, to, color, strong, text, share = COVERING) {
  const { context, camera, palette } = pen;
  context.strokeStyle = palette[color];
  context.lineWidth = strong ? 2 : 1;
  context.setLineDash(strong ? [] : [3, 4]);
  strokePath(context, camera, [[from.x, from.y], [to.x, to.y]]);
  context.setLineDash([]);
  if (!text) return;
  const place = placeOfFigure(pen, camera.toScreen(from.x, from.y), camera.toScreen(to.x, to.y), text, share);
  if (place) drawPlate(context, text, ...place, palette, color === "danger" ? "danger-ink" : "text");
}

/** The place of a figure at the line from a to b where it covers least: on the line, or beside it. */
function placeOfFigure(pen, [ax, ay], [bx, by], text, share) {
  const on = share => [ax + share * (bx - ax), ay + share * (by - ay)];
  const [mx, my] = on(0.5);
  const places = [...[0.5, 0.38, 0.62, 0.26, 0.74].map(on),
    [mx, my - 34], [mx + 72, my], [mx - 72, my], [mx, my + 34], [mx, my - 60], [mx, my + 60],
    [mx + 72, my - 34], [mx - 72, my - 34], [mx + 72, my + 34], [mx - 72, my + 34],
    [mx, my - 84], [mx, my + 84], [mx + 100, my], [mx - 100, my]];
  const wide = plateWidth(pen.context, text);
  const { left, right, top, bottom } = pen.camera.screen;
  const kept = places.map(([x, y]) => [
    Math.max(left + wide / 2 + 2, Math.min(x, right - wide / 2 - 2)), Math.max(top + 12, Math.min(y, bottom - 12))]);
  return takePlace(pen, kept, wide, 20, share);
}

/**
 * The first of the `places` at which a box of that size covers the least that is taken, and is cut off
 * the least at the edge of the screen; takes it. None (null) if at all of them more than a share of it is.
 */
function takePlace({ taken, camera }, places, wide, high, share = Infinity) {
  const { screen } = camera;
  let [best, bestBox, least] = [null, null, Infinity];
  for (const place of places) {
    const [x, y] = place; // and in three dimensions how far away
    const box = { left: x - wide / 2, right: x + wide / 2, top: y - high / 2, bottom: y + high / 2 };
    let cost = wide * high - common(box, screen);
    for (const other of taken) cost += common(box, other);
    if (cost < least) [best, bestBox, least] = [[x, y], box, cost];
    if (least < SLIGHT_COST) break;        // most are free at once
  }
  if (least > share * wide * high) return null;
  taken.push(bestBox);
  return best;
}

/** A square of `size` pixels round a place of the floor. */
function boxRound({ x, y }, size, camera) {
  const [px, py] = camera.toScreen(x, y);
  return { left: px - size / 2, right: px + size / 2, top: py - size / 2, bottom: py + size / 2 };
}

/** The violations so far: a mark each, and for a moment the line itself. */
function drawViolations(pen, run, t, afterglow) {
  const last = lastUpTo(run.violationTimes, t);
  for (let i = Math.max(0, last + 1 - MOST_MARKS); i <= last; i++) {
    const { event, watch, person, other, t: begin } = run.violations[i];
    const [px, py] = pen.camera.toScreen(person.x, person.y);
    if (other && t - begin <= afterglow && !watch?.at(t).violated) {
      const distance = event.distance ?? Math.hypot(person.x - other.x, person.y - other.y);
      drawDistanceLine(pen, person, other, "danger", true, comparison(distance, event.required));
    }
    drawGlyph(pen.context, LOOKS.violation, px, py, pen.palette, 1.5);
    drawText(pen.context, "!", px, py + 1.5, { color: pen.palette.halo, size: 9, weight: 700 });
  }
}

/** A body's name, and why it stands if it is made to. */
function nameNow(run, body, t) {
  if (run.isHeld(body, t)) return `${spoken(body.name)}, on hold`;
  return run.isDisabled(body, t) ? `${spoken(body.name)}, disabled` : spoken(body.name);
}

function drawName(pen, run, body, t) {
  const { context, camera, palette } = pen;
  const { x, y, rotation } = body.motion.at(t);
  const [px, py] = camera.toScreen(x, y);
  if (body.category === "vehicle") {
    const inside = { size: Math.min(12, 0.45 * body.width * camera.scale), weight: 600, color: palette.halo };
    const back = 0.06 * body.length * camera.scale * Math.cos(rotation);
    const words = nameNow(run, body, t);
    if (inside.size >= 8 && textWidth(context, words, inside) <= 0.75 * body.length * camera.scale) {
      drawText(context, words, px - back, py + 0.5, inside);
      return;
    }
    const look = { size: 10, weight: 600, color: palette.muted, halo: palette.halo };
    drawNameBeside(pen, words, px, py, 0.5 * Math.hypot(body.length, body.width) * camera.scale + 6, look, { share: CROWDED });
    return;
  }
  const isRobot = body.category === "robot";
  const name = nameNow(run, body, t);
  const look = { halo: palette.halo, size: 12, weight: 600, color: palette[isRobot ? "robot-ink" : body.color] };
  const round = body.reach ?? Math.hypot(body.length, body.width) / 2;
  const away = isRobot ? round * camera.scale + 10 : Math.max(6, body.radius * camera.scale) + 11;
  drawNameBeside(pen, name, px, py, away, look, { isBelow: isRobot });
}

/**
 * Writes a name where it covers least: above, below, beside or at a slant, `away` pixels from the middle; not
 * where it would be covered by more than a `share`.
 */
function drawNameBeside(pen, name, px, py, away, look, { isBelow = false, share = Infinity } = {}) {
  const wide = textWidth(pen.context, name, look);
  const up = isBelow ? 1 : -1;
  const [beside, slant] = [away + wide / 2, 0.7 * away + wide / 2];
  const places = [
    [px, py + up * away], [px, py - up * away], [px + beside, py], [px - beside, py],
    [px + slant, py - 0.7 * away], [px - slant, py - 0.7 * away], [px + slant, py + 0.7 * away],
    [px - slant, py + 0.7 * away], [px, py - away - 14], [px, py + away + 14],
  ];
  const place = takePlace(pen, places, wide, look.size + 2, share);
  if (place) drawText(pen.context, name, ...place, look);
}
