/* Zones of the floor, and what is not always there: closed doors, and obstacles that come and go. */

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
  for (const { footprint } of thereAt(run, t)) {
    context.fillStyle = palette.high;
    context.strokeStyle = palette.text;
    outline(context, camera, footprint);
    context.fill();
    context.stroke();
  }
}
