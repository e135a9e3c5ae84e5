/* One run in three dimensions on a canvas: the world, the eye, and the gestures. */

const WITHOUT_WEBGL = "This browser has no WebGL 2, which the view in three dimensions needs; here is the floor from above.";
const EYES_AHEAD = 0.12;     // metres of the eyes before the middle of a person

/**
 * Shows a run as `View` does, in three dimensions. Throws an Error where there is no WebGL 2; `onLost` is
 * called where the browser takes it away.
 */
class SpaceView {
  constructor(run, { space, marks }, onResize, onLost) {
    this.canvas = marks;
    this.space = space;
    this.renderer = new Renderer(space, onLost);
    this.camera = new Eye(boxOf(run.plan.boundary), outlineOf(run.plan));
    this.surface = new Surface(marks, onResize);
    this.followed = this.looking = null;
    this.show(run);
  }

  /** Shows another run on the same floor. */
  show(run) {
    this.run = run;
    this.world = new World(run, this.renderer);
    this.world.fieldScale = this.fieldScale ?? null;
    this.world.groups = groupsOf(this.world.lasting.map(obstacle => ({ ...obstacle, box: obstacle.solid.box })));
    if (this.palette) this.world.build(this.palette, this.isDark);
  }

  /** Shows a field over the floor (null: none). */
  showField(scale) {
    const isSame = scale?.isLike(this.fieldScale) ?? !this.fieldScale;
    this.fieldScale = this.world.fieldScale = scale;
    if (!isSame && this.palette) this.world.build(this.palette, this.isDark);
  }

  /** What is drawn with over the picture. */
  get pen() { return { context: this.surface.context, palette: this.palette }; }

  /** Keeps the body of that name in the middle; "" for none. */
  follow(name) {
    this.followed = this.run.bodies.get(name) ?? null;
    if (this.followed) this.camera.distance = Math.min(this.camera.distance, 12);
  }

  /** Looks through the eyes of a person (null: from outside). */
  lookThrough(person) {
    this.looking = person;
    if (!person) this.camera.lookThrough(null);
  }

  /** The colours or the size have changed. */
  restyle(palette) {
    const isDark = document.documentElement.dataset.theme === "dark";
    this.surface.fit();
    this.camera.resize(this.surface);
    const { width, height, ratio } = this.surface;
    for (const [name, length] of [["width", width], ["height", height]]) {
      const pixels = Math.round(length * ratio);
      if (this.space[name] !== pixels) this.space[name] = pixels;
    }
    if (this.palette === palette) return;
    Object.assign(this, { palette, isDark });
    this.world.build(palette, isDark);
  }

  draw(t, chosen, afterglow) {
    const { camera, palette, world, run } = this;
    const body = name => run.bodies.get(name);
    const isHere = one => one && !isAway(one.motion.at(t), camera);
    const looking = this.looking && body(this.looking.name);
    const hidden = isHere(looking) ? looking : null;
    camera.lookThrough(hidden && eyesOf(hidden, t));
    const followed = this.followed && body(this.followed.name);
    if (!hidden && isHere(followed)) camera.lookAt(followed.motion.at(t).x, followed.motion.at(t).y, 0.9);
    const piles = world.at(t, camera, chosen, afterglow, hidden);
    this.renderer.draw(piles, camera, lightOf(palette.page), world.colors.edge);
    const context = this.surface.clear();
    drawMarks({ context, eye: camera, palette, world }, run, t, chosen, afterglow, hidden);
  }

  /** The body or obstacle at a pixel, in lines of text; [] if there is none. */
  describe(px, py, t) {
    const found = this.#under(px, py, t);
    if (found?.motion) return wordsOfBody(found, t);
    return found ? [spoken(found.name), `${found.bottom} to ${found.top} m high`] : [];
  }

  /** The floor in words, for screen readers. */
  inWords(t) {
    return floorInWords(this.run, t);
  }

  /** The body at a pixel, or undefined. */
  bodyAt(px, py, t) {
    const found = this.#under(px, py, t);
    return found?.motion ? found : undefined;
  }

  /** The nearest body or obstacle under a pixel; of bodies also one that is only just missed. */
  #under(px, py, t) {
    const { camera, run, world } = this;
    const far = camera.position.map((value, i) => value + 500 * camera.ray(px, py)[i]);
    const looked = this.looking?.name;
    const things = [
      ...world.bodiesAt(t, camera).filter(({ name }) => name !== looked).map(body => [body, solidOfBody(body, t)]),
      ...world.obstacles.filter(({ top }) => top < HIDING || camera.inside).map(obstacle => [obstacle, obstacle.solid]),
    ].map(([thing, solid]) => [entryInto(solid, camera.position, far), thing]).sort((a, b) => a[0] - b[0]);
    return things[0]?.[0] < Infinity ? things[0][1] : undefined;
  }
}

/** The points between which all of a floor stands. */
function outlineOf({ boundary, obstacles, gantry }) {
  const tops = obstacles.flatMap(({ footprint, top }) => footprint.map(point => [...point, top]));
  const rails = (gantry?.x ?? []).flatMap(x => gantry.y.map(y => [x, y, gantry.rail_height ?? RAIL_HEIGHT]));
  return [...boundary.map(point => [...point, 0]), ...tops, ...rails];
}

/** The eyes of a person at t: {x, y, z, heading}. */
function eyesOf(person, t) {
  const { x, y } = person.motion.at(t);
  const heading = person.motion.heading(t, 0.8);
  return {
    x: x + EYES_AHEAD * Math.cos(heading), y: y + EYES_AHEAD * Math.sin(heading),
    z: EYE_LEVEL * (person.height ?? TALL), heading,
  };
}
