/* What of a run is seen in three dimensions at an instant, as piles of shapes. */

const PAINTED = 2048;        // pixels of the longer side of the picture on the floor
const HIDING = 1.5;          // metres: what is higher than this can hide people, and is seen through then
const VOLUME = 1.9;          // metres up to which the protective distance is shown
const KERB = 0.08;           // metres of the floor's edge
const CLOSEST = 0.2;         // metres between two points of a trail
const MARKED = 0.02;         // metres above the floor of what is marked on it
const FEW_WATCHED = 8;       // people, of whom each is kept in sight

const RINGS = new Map();     // of which there is a shape, by how fine they are

/** Fixed colours beside those of the theme. */
const PAINTS = {
  skin: "#c8966e", helmet: "#f4f1e6", stripe: "#f2f0d8", ink: "#23272b", steel: "#8d949b", wood: "#b98d57",
  bin: "#5c7f96", arm: "#e3e4e2",
};
const PAINTS_OF_DARKNESS = { helmet: "#d8d5ca", stripe: "#d9d7bd", cloth: "#454e58", steel: "#7b838b", arm: "#bfc1c0" };

class World {
  constructor(run, renderer) {
    this.run = run;
    this.renderer = renderer;
    this.moving = new Pile();
    this.fieldScale = null;    // of the field that is shown
    const solid = obstacle => (
      { ...obstacle, solid: uprightSolid(obstacle.footprint, obstacle.bottom, obstacle.top) });
    this.lasting = run.plan.obstacles.map(solid);
    this.passing = new Map(run.comings.things.map(thing => [thing, solid(thing)]));
    this.obstacles = this.lasting;         // those that are there at the instant shown
  }

  /** The bodies that are on the floor at t. */
  bodiesAt(t, eye) {
    return [...this.run.bodies.values()].filter(body => !isAway(body.motion.at(t), eye));
  }

  /** Builds what does not move, in the colours of a theme. */
  build(palette, isDark) {
    const paints = { cloth: "#3d4854", ...PAINTS, ...(isDark ? PAINTS_OF_DARKNESS : {}) };
    this.colors = Object.fromEntries(Object.entries({ ...palette, ...paints })
      .map(([name, color]) => [name, lightOf(color)]));
    const { plan } = this.run;
    const { colors, renderer } = this;
    this.fixed = new Pile();
    for (const obstacle of this.lasting) {
      if (obstacle.top < HIDING) addObstacle(this.fixed, renderer, obstacle, colors);
    }
    for (const ring of [plan.boundary, ...plan.holes ?? []]) this.#addKerb(ring);
    if (plan.gantry) addRails(this.fixed, plan.gantry, colors);
    const bounds = boxOf(plan.boundary);
    renderer.paint(floorPicture(this.run, bounds, palette, this.#isFieldOfRun ? this.fieldScale : null), bounds);
  }

  #addKerb(ring) {
    ring.forEach(([ax, ay], i) => {
      const [bx, by] = ring[(i + 1) % ring.length];
      const middle = frameAt((ax + bx) / 2, (ay + by) / 2, 0, Math.atan2(by - ay, bx - ax));
      this.fixed.add("box", "edged", sized(middle, Math.hypot(bx - ax, by - ay) + 0.1, 0.1, KERB), this.colors.edge);
    });
  }

  /** The piles at t, as `eye` sees them; `chosen` is the watch in focus, `hidden` a body that is not drawn. */
  at(t, eye, chosen, afterglow, hidden) {
    const { run, moving, colors } = this;
    moving.clear();
    const bodies = this.bodiesAt(t, eye);
    const sought = this.#sought(chosen).filter(body => bodies.includes(body))
      .map(body => [body.motion.at(t).x, body.motion.at(t).y, 1]);
    if (!eye.inside) sought.push(eye.target);
    const come = this.passing.size ? thereAt(run, t).map(thing => this.passing.get(thing)) : [];
    this.obstacles = [...this.lasting, ...come];
    for (const obstacle of this.obstacles) {
      if (obstacle.top < HIDING && !come.includes(obstacle)) continue;
      const hides = !eye.inside && sought.some(place => entryInto(obstacle.solid, eye.position, place) < 1);
      addObstacle(moving, this.renderer, obstacle, colors, hides ? "pane" : "edged");
    }
    const belt = this.lasting.find(({ name }) => name === "conveyor")?.top ?? 0;
    const side = eye.inside ? PART_SIZE : partSize(eye.scale);
    for (const { x, y, paint } of conveyedAt(run, t)) {
      moving.add("box", "edged", sized(frameAt(x, y, belt, 0), side, side, PART_HEIGHT * side / PART_SIZE), lightOf(paint));
    }
    for (const body of bodies) {
      if (body === hidden) continue;
      if (body.category === "person") addFigure(moving, body, t, colors[body.color], colors);
      else if (body.category === "vehicle") addVehicle(moving, this.renderer, body, t, colors);
      else addRobot(moving, body, t, run.isDisabled(body, t), colors);
    }
    const shown = run.shown(chosen, t).filter(watch => bodies.includes(watch.person) && bodies.includes(watch.other));
    for (const watch of shown) if (watch.person !== hidden) this.#addDistances(watch, t);
    if (this.fieldScale && !this.#isFieldOfRun) addField(moving, run, this.fieldScale, t, MARKED / 2);
    for (const body of bodies) if (body.fields) addFields(moving, this.renderer, run, body, t, colors);
    addWaits(moving, run, t, MARKED, colors.notice);
    for (const body of bodies) this.#addTrail(body, t);
    for (const body of bodies) if (body.category === "person") this.#addPathAhead(body, t, afterglow);
    for (const watch of run.watches) {
      if (shown.includes(watch) || watch.violatedAt(t)) this.#addLine(watch, t);
    }
    return [this.fixed, moving];
  }

  get #isFieldOfRun() { return Boolean(this.fieldScale && FIELDS[this.fieldScale.kind].isOfRun); }

  /** The bodies that walls must not hide. */
  #sought(chosen) {
    const { people } = this.run;
    const pair = chosen ? [chosen.person, chosen.other] : [];
    return [...new Set([...pair, ...people.length <= FEW_WATCHED ? people : []])];
  }

  /** The protective distance as a volume round the person, the noticing distance as a ring on the floor. */
  #addDistances(watch, t) {
    const { moving, colors } = this;
    const { x, y } = watch.person.motion.at(t);
    const { required, notice, violated, margin } = watch.at(t);
    const color = colors[violated || margin < 0 ? "danger" : watch.person.color];
    const radius = required + watch.added;
    const round = height => sized(frameAt(x, y, MARKED), 2 * radius, 2 * radius, height);
    if (notice !== null) this.#addRing(x, y, notice + watch.added, 0.03, color, 0.6);
    moving.add("disc", violated ? "striped" : "glow", round(1), color, violated ? 0.22 : 0.13);
    moving.add("tube", violated ? "striped" : "glow", round(VOLUME), color, violated ? 0.42 : 0.34);
    this.#addRing(x, y, radius, violated ? 0.08 : 0.045, color, 0.95);
  }

  #addRing(x, y, radius, width, color, opacity) {
    if (!(radius > 0)) return;
    const shape = this.renderer.learned(...ringShape(width / (2 * radius)));
    this.moving.add(shape, "glow", sized(frameAt(x, y, MARKED), 2 * radius, 2 * radius, 1), color, opacity);
  }

  #addTrail(body, t) {
    const color = this.colors[body.color];
    body.track.behind(t, TRAIL, TRAIL_GRAIN, (points, age) => {
      let last = points[0];
      points.forEach((point, i) => {
        if (i < points.length - 1 && Math.hypot(point[0] - last[0], point[1] - last[1]) < CLOSEST) return;
        const strip = stripFrom(last, point, MARKED, body.category === "person" ? 0.09 : 0.05);
        this.moving.add("square", "glow", strip, color, 0.6 * (1 - age / TRAIL));
        last = point;
      });
    });
  }

  #addPathAhead(person, t, afterglow) {
    const { moving, colors } = this;
    const color = colors[person.color];
    addPathAhead(moving, person, t, MARKED, color);
    const jump = person.motion.lastJump(t);
    if (!jump || t - jump.t > afterglow || Math.hypot(jump.to.x - jump.from.x, jump.to.y - jump.from.y) > AWAY) return;
    for (const { from, to } of dashesOf([[jump.from.x, jump.from.y], [jump.to.x, jump.to.y]])) {
      moving.add("square", "glow", stripFrom(from, to, MARKED, 0.03), color, 1 - 0.8 * ((t - jump.t) / afterglow));
    }
  }

  /** The line between two bodies whose distance is shown. */
  #addLine(watch, t) {
    const [from, to] = [watch.person, watch.other].map(body => body.motion.at(t));
    const { violated } = watch.at(t);
    const strip = stripFrom([from.x, from.y], [to.x, to.y], MARKED + 0.01, violated ? 0.07 : 0.03);
    this.moving.add("square", "glow", strip, this.colors[violated ? "danger" : "muted"], violated ? 1 : 0.7);
  }
}

/** What belongs to a ring that is about so wide, of its diameter, and what makes its shape. */
function ringShape(share) {
  const step = Math.round(4 * Math.log2(Math.min(share, 0.25)));
  if (!RINGS.has(step)) RINGS.set(step, {});
  return [RINGS.get(step), () => ringMesh(2 ** (step / 4))];
}

/** What is painted on the floor: ground, lanes, stations, safe zone, and a field that lasts. */
function floorPicture(run, bounds, palette, fieldScale) {
  const { plan } = run;
  const [wide, high] = [bounds.right - bounds.left, bounds.top - bounds.bottom];
  const scale = PAINTED / 2 / Math.max(wide, high);
  const canvas = document.createElement("canvas");
  canvas.width = Math.max(1, Math.round(2 * scale * wide));
  canvas.height = Math.max(1, Math.round(2 * scale * high));
  const context = canvas.getContext("2d");
  context.scale(2, 2);
  const toScreen = (x, y) => [(x - bounds.left) * scale, (bounds.top - y) * scale];
  const pen = { context, camera: { scale, toScreen }, palette };
  new FloorLayer(plan).paintGround(pen);
  drawRules(pen, plan);
  if (fieldScale) drawField(pen, run, fieldScale, 0);
  return canvas;
}
