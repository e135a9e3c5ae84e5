/* What moves. */

const TRAIL = 12;            // seconds of the way behind that are shown
const AFTERGLOW = 2.5;       // seconds for which a violation and a teleport stay on the floor in full
const MOST_MARKS = 200;       // of the violations so far, the latest are marked on the floor
const PERSON_COLORS = ["person-1", "person-2", "person-3", "person-4"];

/** A body of the recording with its motion. */
class Body {
  constructor(data, pieces, duration, color) {
    Object.assign(this, data);
    this.color = color;
    this.duration = duration;
    this.motion = new Motion(pieces);
    this.track = new Track(this.motion);
  }
}

/** Everything that changes with time, drawn over the floor. */
class Scene {
  constructor(recording, bodies, watches) {
    this.plan = recording.floorplan;
    this.bodies = [...bodies.values()];
    this.watches = watches;
    this.people = this.bodies.filter(body => body.kind === "person");
    this.disabled = disabledIntervals(recording.events, recording.duration);
    this.disabledBegins = this.disabled.map(interval => interval[0]);
    this.violations = recording.events.filter(event => event.kind === "violation" && bodies.has(event.person))
      .map(event => ({
        t: event.t,
        event,
        watch: watches.find(watch => watch.person.name === event.person && watch.other.name === event.with),
        person: bodies.get(event.person).motion.before(event.t),
        other: bodies.get(event.with)?.motion.before(event.t),
      }));
    this.violationTimes = this.violations.map(violation => violation.t);
  }

  /** The watch to show of each person: the chosen one (last, on top), or the first there is. */
  shown(chosen) {
    const others = this.people.filter(person => person !== chosen?.person)
      .map(person => this.watches.find(watch => watch.person === person));
    return [...others, chosen].filter(Boolean);
  }

  /** The violation of a watch that was counted last, if that was within `afterglow` seconds. */
  violationLately(watch, t, afterglow) {
    for (let i = lastUpTo(this.violationTimes, t); i >= 0 && t - this.violationTimes[i] <= afterglow; i--) {
      if (this.violations[i].watch === watch) return this.violations[i].event;
    }
    return undefined;
  }

  isDisabled(t) {
    const i = lastUpTo(this.disabledBegins, t);
    return i >= 0 && t < this.disabled[i][1];
  }

  /** The body whose centre is nearest to a place of the floor, within `reach` metres. */
  bodyAt(t, x, y, reach) {
    const away = body => {
      const at = body.motion.at(t);
      return Math.hypot(at.x - x, at.y - y);
    };
    return this.bodies.map(body => [away(body), body])
      .filter(([distance]) => distance <= reach).sort((a, b) => a[0] - b[0])[0]?.[1];
  }

  draw(pen, t, chosen, afterglow) {
    const shown = this.shown(chosen);
    for (const watch of shown) this.#drawDistances(pen, watch, t);
    for (const body of this.bodies) this.#drawTrail(pen, body, t);
    for (const body of this.bodies) if (body.kind === "agv") this.#drawAgv(pen, body, t);
    for (const person of this.people) this.#drawPathAhead(pen, person, t);
    for (const body of this.bodies) if (body.kind === "gantry") this.#drawGantry(pen, body, t);
    for (const person of this.people) this.#drawPerson(pen, person, t, afterglow);
    for (const body of this.bodies) this.#drawName(pen, body, t, shown);
    this.#drawViolations(pen, t, afterglow);
    const violated = this.watches.filter(watch => !shown.includes(watch) && watch.at(t).violated);
    for (const watch of [...violated, ...shown]) this.#drawSeparation(pen, watch, t);
  }

  /** The protective distance as a disc round the person, the noticing distance as a thin ring. */
  #drawDistances({ context, camera, palette, hatch }, watch, t) {
    const { x, y } = watch.person.motion.at(t);
    const [px, py] = camera.toScreen(x, y);
    const { required, notice, violated } = watch.at(t);
    const color = palette[violated ? "danger" : watch.person.color];
    context.beginPath();
    context.arc(px, py, required * camera.scale, 0, 2 * Math.PI);
    alpha(context, violated ? 0.2 : 0.1, () => {
      context.fillStyle = color;
      context.fill();
    });
    if (violated) {
      alpha(context, 0.35, () => {
        context.fillStyle = hatch;
        context.fill();
      });
    }
    context.strokeStyle = color;
    context.lineWidth = violated ? 2.5 : 1.25;
    alpha(context, 0.9, () => context.stroke());
    if (notice === null) return;
    context.beginPath();
    context.arc(px, py, notice * camera.scale, 0, 2 * Math.PI);
    context.lineWidth = 1;
    context.setLineDash([2, 4]);
    alpha(context, 0.6, () => context.stroke());
    context.setLineDash([]);
  }

  #drawTrail({ context, camera, palette }, body, t) {
    context.strokeStyle = palette[body.color];
    context.lineWidth = body.kind === "person" ? 3 : 2;
    body.track.behind(t, TRAIL, (x0, y0, x1, y1, age) => {
      alpha(context, 0.6 * (1 - age / TRAIL), () => strokeLine(context, camera, [x0, y0], [x1, y1]));
    });
  }

  #drawPathAhead({ context, camera, palette }, person, t) {
    const points = person.track.ahead(t);
    if (points.length < 2) return;
    context.strokeStyle = palette[person.color];
    context.lineWidth = 1.5;
    context.setLineDash([5, 4]);
    context.beginPath();
    for (const [x, y] of points) context.lineTo(...camera.toScreen(x, y));
    context.stroke();
    context.setLineDash([]);
    const [px, py] = camera.toScreen(...points.at(-1));
    context.beginPath();
    context.arc(px, py, 3, 0, 2 * Math.PI);
    context.fillStyle = palette[person.color];
    context.fill();
  }

  #drawPerson({ context, camera, palette }, person, t, afterglow) {
    const { x, y } = person.motion.at(t);
    const [px, py] = camera.toScreen(x, y);
    const radius = Math.max(6, person.radius * camera.scale);
    this.#drawTeleport({ context, camera, palette }, person, t, afterglow);
    context.save();
    context.translate(px, py);
    context.rotate(-person.motion.heading(t));
    context.beginPath();                   // the heading: a nose ahead of the disc
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

  /** Where a person was put from: a thin line for a moment. */
  #drawTeleport({ context, camera, palette }, person, t, afterglow) {
    const jump = person.motion.lastJump(t);
    if (!jump || t - jump.t > afterglow) return;
    context.strokeStyle = palette[person.color];
    context.lineWidth = 1.25;
    context.setLineDash([1, 4]);
    alpha(context, 1 - 0.8 * ((t - jump.t) / afterglow), () => strokeLine(
      context, camera, [jump.from.x, jump.from.y], [jump.to.x, jump.to.y]));
    context.setLineDash([]);
  }

  #drawAgv({ context, camera, palette }, agv, t) {
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

  #drawGantry({ context, camera, palette, hatch }, gantry, t) {
    const { x, y, rotation } = gantry.motion.at(t);
    const disabled = this.isDisabled(t);
    const [px, py] = camera.toScreen(x, y);
    context.strokeStyle = palette.gantry;
    if (this.plan.gantry) {
      const half = Math.max(3, 0.2 * camera.scale);
      const [, low] = camera.toScreen(x, this.plan.gantry.y[0]);
      const [, high] = camera.toScreen(x, this.plan.gantry.y[1]);
      context.lineWidth = 1.5;
      alpha(context, 0.8, () => context.strokeRect(px - half, high - half, 2 * half, low - high + 2 * half));
      alpha(context, 0.12, () => {
        context.fillStyle = palette.gantry;
        context.fillRect(px - half, high - half, 2 * half, low - high + 2 * half);
      });
    }
    const [length, width] = [gantry.length * camera.scale, gantry.width * camera.scale];
    context.save();
    context.translate(px, py);
    context.rotate(-rotation);
    context.lineWidth = 1.25;
    context.setLineDash([3, 3]);           // how far the folded arm reaches
    context.beginPath();
    context.arc(0, 0, gantry.reach * camera.scale, 0, 2 * Math.PI);
    context.stroke();
    context.setLineDash([]);
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
    context.beginPath();                   // the arm, from its mount to its reach
    context.moveTo(gantry.mount * camera.scale, 0);
    context.lineTo(gantry.reach * camera.scale, 0);
    context.lineWidth = Math.max(2.5, 0.14 * camera.scale);
    context.lineCap = "round";
    context.stroke();
    context.beginPath();
    context.arc(gantry.mount * camera.scale, 0, Math.max(2.5, 0.13 * camera.scale), 0, 2 * Math.PI);
    context.fillStyle = palette["gantry-ink"];
    context.fill();
    context.restore();
  }

  /** The line between two bodies, with their distance. */
  #drawSeparation(pen, watch, t) {
    const { distance, required, notice, violated } = watch.at(t);
    const person = watch.person.motion.at(t);
    const other = watch.other.motion.at(t);
    const noticed = notice !== null && distance < notice;
    this.#drawDistanceLine(pen, person, other, violated ? "danger" : "muted", violated || noticed,
      violated ? comparison(distance, required) : metres(distance));
  }

  #drawDistanceLine({ context, camera, palette }, from, to, color, strong, text) {
    context.strokeStyle = palette[color];
    context.lineWidth = strong ? 2 : 1;
    context.setLineDash(strong ? [] : [3, 4]);
    strokeLine(context, camera, [from.x, from.y], [to.x, to.y]);
    context.setLineDash([]);
    const [px, py] = camera.toScreen((from.x + to.x) / 2, (from.y + to.y) / 2);
    const [dx, dy] = [Math.abs(from.x - to.x), Math.abs(from.y - to.y)];
    const isShort = Math.hypot(dx, dy) * camera.scale < 130;      // beside the line, not over the bodies
    const [aside, up] = isShort ? (dx > dy ? [0, 34] : [72, 0]) : [0, 0];
    drawPlate(context, text, px + aside, py - up, palette, color === "danger" ? "danger-ink" : "text");
  }

  /** Where people came too close so far: a mark each, and for a moment the line itself. */
  #drawViolations(pen, t, afterglow) {
    const last = lastUpTo(this.violationTimes, t);
    for (let i = Math.max(0, last + 1 - MOST_MARKS); i <= last; i++) {
      const { event, watch, person, other, t: begin } = this.violations[i];
      const [px, py] = pen.camera.toScreen(person.x, person.y);
      if (other && t - begin <= afterglow && !watch?.at(t).violated) {
        const distance = event.distance ?? Math.hypot(person.x - other.x, person.y - other.y);
        this.#drawDistanceLine(pen, person, other, "danger", true, comparison(distance, event.required));
      }
      drawGlyph(pen.context, LOOKS.violation, px, py, pen.palette, 1.5);
      drawText(pen.context, "!", px, py + 1.5, { color: pen.palette.halo, size: 9, weight: 700 });
    }
  }

  #drawName({ context, camera, palette }, body, t, shown) {
    const { x, y, rotation } = body.motion.at(t);
    const [px, py] = camera.toScreen(x, y);
    const look = { halo: palette.halo, size: 12, weight: 600 };
    if (body.kind === "agv") {
      const size = Math.min(12, 0.45 * body.width * camera.scale);
      const back = 0.06 * body.length * camera.scale * Math.cos(rotation);
      if (size < 7) return;
      drawText(context, spoken(body.name), px - back, py + 0.5, { size, weight: 600, color: palette.halo });
    } else if (body.kind === "gantry") {
      const name = this.isDisabled(t) ? `${spoken(body.name)}, disabled` : spoken(body.name);
      const below = body.reach * camera.scale + 10;
      drawText(context, name, px, py + below, { ...look, color: palette["gantry-ink"] });
    } else {
      const away = Math.max(6, body.radius * camera.scale) + 11;
      const other = shown.find(watch => watch.person === body)?.other.motion.at(t);
      const isCrowded = other && other.y > y && Math.hypot(other.x - x, other.y - y) < 3;
      drawText(context, spoken(body.name), px, isCrowded ? py + away : py - away,
        { ...look, color: palette[body.color] });
    }
  }
}

/** When the gantry was switched off: [[begin, end], …]. */
function disabledIntervals(events, duration) {
  const intervals = [];
  for (const { kind, t } of events) {
    const open = intervals.at(-1)?.[1] === duration && intervals.at(-1);
    if (kind === "gantry_disabled" && !open) intervals.push([t, duration]);
    if (kind === "gantry_enabled" && open) open[1] = t;
  }
  return intervals;
}
