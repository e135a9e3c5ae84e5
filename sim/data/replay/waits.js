/* Who waits for whom: arrows from the machines that wait to those for which they do. */

const WAIT_HEAD = 9;         // pixels of an arrow's head

/** The waits of machines for one another: {t, end, machine, for} in order of time. */
function waitsOf(events, end) {
  const waits = [];
  const open = new Map();
  for (const event of events) {
    if (event.kind !== "machine_waiting" && event.kind !== "machine_proceeds") continue;
    const last = open.get(event.machine);
    if (last) last.end = event.t;
    open.delete(event.machine);
    if (event.kind === "machine_proceeds") continue;
    waits.push({ t: event.t, end, machine: event.machine, for: event.for_machine });
    open.set(event.machine, waits.at(-1));
  }
  return waits;
}

/** The pairs of places between which an arrow stands at t: [of who waits, of the other machine]. */
function waitingAt(run, t) {
  return run.waits.filter(wait => wait.t <= t && t < wait.end)
    .map(wait => [wait.machine, wait.for].map(name => run.bodies.get(name)?.motion.at(t)))
    .filter(([from, to]) => from && to);
}

function drawWaits({ context, camera, palette }, run, t) {
  context.strokeStyle = context.fillStyle = palette.notice;
  context.lineWidth = 2;
  for (const places of waitingAt(run, t)) {
    const [[ax, ay], [bx, by]] = places.map(({ x, y }) => camera.toScreen(x, y));
    const angle = Math.atan2(by - ay, bx - ax);
    context.setLineDash([6, 4]);
    strokePath(context, camera, places.map(({ x, y }) => [x, y]));
    context.setLineDash([]);
    context.beginPath();
    context.moveTo(bx, by);
    for (const side of [-0.4, 0.4]) {
      context.lineTo(bx - WAIT_HEAD * Math.cos(angle + side), by - WAIT_HEAD * Math.sin(angle + side));
    }
    context.fill();
  }
}

/** The same in three dimensions: dashes on the floor. */
function addWaits(pile, run, t, height, color) {
  for (const places of waitingAt(run, t)) {
    for (const { from, to } of dashesOf(places.map(({ x, y }) => [x, y]))) {
      pile.add("square", "glow", stripFrom(from, to, height, 0.06), color, 0.9);
    }
  }
}
