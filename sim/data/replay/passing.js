/* Zones of the floor, and what is not always there: closed doors, and obstacles that come and go. */

const COMES = ["door_closed", "obstacle_came"];
const GOES = ["door_opened", "obstacle_went"];

/** The `passing` obstacles that are there at t, by the last event about each. */
function thereAt(run, t) {
  const there = new Set();
  for (const event of run.events) {
    if (event.t > t) break;
    if (COMES.includes(event.kind)) there.add(event.door ?? event.obstacle);
    if (GOES.includes(event.kind)) there.delete(event.door ?? event.obstacle);
  }
  return (run.recording.passing ?? []).filter(thing => there.has(thing.name));
}

/** Zones as dashed outlines, forbidden ones in the colour of danger. */
function drawZones({ context, camera, palette }, { zones = [] }) {
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

/** Zones, and what is there at t. */
function drawPassing({ context, camera, palette }, run, t) {
  drawZones({ context, camera, palette }, run.plan);
  if (!run.recording.passing) return;
  for (const { footprint } of thereAt(run, t)) {
    context.fillStyle = palette.high;
    context.strokeStyle = palette.text;
    outline(context, camera, footprint);
    context.fill();
    context.stroke();
  }
}
