/* Paths as dashes on the floor: those ahead of people lie still, and are worked out once for each leg. */

const DASH = 0.3;            // metres of a dash, and of the gap after it
const DASH_WIDTH = 0.045;
const DASH_OPACITY = 0.9;

/** The dashes of one leg of a track, from its end back to its beginning. */
class DashedLeg {
  constructor(leg, z, color) {
    Object.assign(this, { leg, z, color });
    this.dashes = dashesOf(Array.from(leg.xs, (x, i) => [x, leg.ys[i]]).reverse());
    this.begins = this.dashes.map(({ far }) => far);
    this.copies = new Copies("square", "glow");
    for (const { from, to } of this.dashes) this.#addTo(this.copies, from, to);
  }

  /** Adds the dashes ahead of who is at a place of the leg, `rest` metres before its end. */
  addAhead(copies, place, rest) {
    const whole = lastUpTo(this.begins, rest) + 1;
    copies.append(this.copies, whole);
    const next = this.dashes[whole];
    if (next && next.near < rest) this.#addTo(copies, next.from, place);
  }

  #addTo(copies, from, to) {
    copies.add(stripFrom(from, to, this.z, DASH_WIDTH), this.color, DASH_OPACITY);
  }
}

/** Puts the path ahead of a person on a pile. */
function addPathAhead(pile, person, t, z, color) {
  const leg = person.track.legAt(t);
  if (!leg) return;
  if (person.dashed?.leg !== leg || person.dashed.color !== color) person.dashed = new DashedLeg(leg, z, color);
  const { x, y } = person.motion.at(t);
  const next = lastUpTo(leg.times, t) + 1;
  const rest = leg.rests[next] + Math.hypot(leg.xs[next] - x, leg.ys[next] - y);
  person.dashed.addAhead(pile.of("square", "glow"), [x, y], rest);
}

/** The dashes of a line of points: [{from, to, near, far}], the last two in metres along the line. */
function dashesOf(points) {
  const dashes = [];
  let gone = 0;
  for (let i = 1; i < points.length; i++) {
    const [[ax, ay], [bx, by]] = [points[i - 1], points[i]];
    const length = Math.hypot(bx - ax, by - ay);
    for (let at = 0; at < length;) {
      const next = Math.min(length, at + DASH - (gone % DASH) + 1e-9);
      const share = metres => [ax + (metres / length) * (bx - ax), ay + (metres / length) * (by - ay)];
      if (Math.floor(gone / DASH) % 2 === 0) {
        dashes.push({ from: share(at), to: share(next), near: gone, far: gone + next - at });
      }
      gone += next - at;
      at = next;
    }
  }
  return dashes;
}
