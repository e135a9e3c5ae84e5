/* How the page hangs together: what is shown, and what mouse, fingers and keys do. */

const CLICK_TREMOR = 3;        // pixels that a pointer may move while it clicks
const FOLLOW_SCALE = 45;       // pixels a metre, at least, when a body is followed

const CONTROL_KEYS = [" ", "ArrowLeft", "ArrowRight", "Home", "End"];    // those that controls use themselves
const PLAY = "M4 2.5v11L13.5 8z";
const PAUSE = "M3.5 2.5h3v11h-3zm6 0h3v11h-3z";

class Replay {
  constructor(recording) {
    this.recording = recording;
    const { duration } = recording;
    this.bodies = new Map();
    let people = 0;
    for (const data of recording.bodies) {
      const color = data.kind === "person" ? PERSON_COLORS[people++ % PERSON_COLORS.length] : data.kind;
      this.bodies.set(data.name, new Body(data, recording.motions[data.name], duration, color));
    }
    this.watches = recording.watches.map(watch => new Watch(watch, this.bodies));
    this.followed = null;

    this.clock = new Clock(duration, () => this.refresh());
    this.scene = new Scene(recording, this.bodies, this.watches);
    this.layer = new FloorLayer(recording.floorplan);
    this.camera = new Camera(boxOf(recording.floorplan.boundary));
    this.floor = new Surface($("floor"), () => this.redraw());
    this.chart = new Chart($("chart"), recording, this.bodies, this.scene.disabled, () => this.redraw());
    this.eventList = new EventList(recording.events, this.bodies, t => this.clock.seek(t));
    showSummary(recording.summary, t => this.clock.seek(t));

    this.#fillIn();
    this.chooseWatch(this.watches.find(watch => watch.violations.length) ?? this.watches[0]);
    this.#wireButtons();
    this.#wireKeys();
    this.#wireFloor();
    this.#wireChart();
    const systemIsDark = matchMedia("(prefers-color-scheme: dark)");
    systemIsDark.addEventListener("change", () => this.setTheme(systemIsDark.matches));
    this.setTheme(systemIsDark.matches);
    const linked = Number.parseFloat(new URLSearchParams(location.hash.slice(1)).get("t"));
    if (Number.isFinite(linked)) this.clock.seek(linked);
  }

  setTheme(dark) {
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    this.palette = readPalette();
    this.redraw();
  }

  chooseWatch(watch) {
    this.watch = watch;
    $("watch").value = this.watches.indexOf(watch);
    if (watch) document.documentElement.style.setProperty("--shown", `var(--${watch.person.color})`);
    this.redraw();
  }

  follow(name) {
    this.followed = this.bodies.get(name) ?? null;
    if (this.followed) this.camera.scale = Math.max(this.camera.scale, FOLLOW_SCALE);
    $("follow").value = this.followed?.name ?? "";
    this.refresh();
  }

  /** Everything again: sizes, colours or the watch have changed. */
  redraw() {
    this.isStale = true;
    this.refresh();
  }

  /** A new frame soon, unless one is coming anyway. */
  refresh() {
    this.frame ??= requestAnimationFrame(now => this.#drawFrame(now));
  }

  #drawFrame(now) {
    this.frame = null;
    const { clock } = this;
    if (clock.isPlaying && !this.isScrubbing) clock.advance((now - (this.lastFrame ?? now)) / 1000);
    this.lastFrame = clock.isPlaying ? now : undefined;
    if (this.isStale) {
      this.isStale = false;
      this.hatch = hatching(this.floor.context, this.palette.danger, this.floor.ratio);
      this.layer.invalidate();
      this.camera.resize(this.floor);
      this.chart.draw(this.watch, this.palette);
    }
    this.#drawFloor();
    this.#showTime();
    if (clock.isPlaying) this.refresh();
  }

  #drawFloor() {
    const { camera, palette, hatch, clock } = this;
    if (this.followed) {
      const { x, y } = this.followed.motion.at(clock.time);
      camera.lookAt(x, y);
    }
    const context = this.floor.clear();
    this.layer.draw(context, camera, palette);
    this.scene.draw({ context, camera, palette, hatch }, clock.time, this.watch, this.#afterglow);
    this.#drawScale(context);
  }

  /** In seconds of the recording: as long for the viewer at any speed. */
  get #afterglow() {
    return AFTERGLOW * Math.max(1, this.clock.isPlaying ? this.clock.speed : 1);
  }

  #drawScale(context) {
    const length = [0.5, 1, 2, 5, 10, 20, 50].find(m => m * this.camera.scale >= 48) ?? 100;
    const y = this.floor.height - 12;
    const right = 12 + length * this.camera.scale;
    context.strokeStyle = this.palette.muted;
    context.lineWidth = 1.25;
    context.beginPath();
    context.moveTo(12, y - 4);
    context.lineTo(12, y);
    context.lineTo(right, y);
    context.lineTo(right, y - 4);
    context.stroke();
    const { muted: color, halo } = this.palette;
    drawText(context, `${length} m`, right + 6, y - 2, { color, halo, align: "left" });
  }

  #showTime() {
    const { clock } = this;
    const t = clock.time;
    this.chart.moveCursor(t);
    showNumbers(this.watch, t, this.watch && this.scene.violationLately(this.watch, t, this.#afterglow));
    this.eventList.show(t);
    const chart = $("chart");
    chart.setAttribute("aria-valuenow", t.toFixed(2));
    if ($("play").dataset.playing !== String(clock.isPlaying)) {
      $("play").dataset.playing = clock.isPlaying;
      $("play").setAttribute("aria-label", clock.isPlaying ? "Pause" : "Play");
      $("play").querySelector("path").setAttribute("d", clock.isPlaying ? PAUSE : PLAY);
    }
    $("speed").value = clock.speed;
    if (clock.isPlaying) return;
    chart.setAttribute("aria-valuetext", `${t.toFixed(1)} seconds`);
    $("floor").setAttribute("aria-label", this.#inWords(t));
  }

  /** What the floor shows, for those who don't see it. */
  #inWords(t) {
    const bodies = [...this.bodies.values()].map(({ name, motion }) => {
      const { x, y, speed } = motion.at(t);
      const doing = speed > STILL ? `moving at ${speed.toFixed(1)} m/s` : "standing";
      return `${spoken(name)} ${doing} at ${x.toFixed(1)}, ${y.toFixed(1)}`;
    });
    return `The floor after ${t.toFixed(1)} seconds: ${bodies.join("; ")}.`;
  }

  /** What the recording says once and for all. */
  #fillIn() {
    const { floorplan, title, duration, bodies } = this.recording;
    const people = bodies.filter(body => body.personality)
      .map(body => `${spoken(body.name)}: ${body.personality}`);
    $("title").textContent = title ?? "";
    $("subtitle").textContent = [floorplan.title || spoken(floorplan.name ?? ""), ...people].join(" · ");
    $("clock-end").textContent = `/ ${duration} s`;
    $("chart").setAttribute("aria-valuemax", duration);
    const option = (value, text) => element("option", { value, text });
    $("speed").append(...SPEEDS.map(speed => option(speed, `${speed}×`)));
    $("follow").append(...bodies.map(({ name }) => option(name, spoken(name))));
    $("watch").append(...this.watches.map((watch, i) => option(i, watch.name)));
    document.body.classList.toggle("unwatched", this.watches.length === 0);
  }

  #wireButtons() {
    const { clock } = this;
    const on = (id, action) => $(id).addEventListener("click", action);
    on("play", () => this.toggle());
    on("previous", () => this.jump(-1));
    on("next", () => this.jump(1));
    on("zoom-in", () => this.zoom(1.4));
    on("zoom-out", () => this.zoom(1 / 1.4));
    on("fit", () => this.fit());
    on("theme", () => this.setTheme(document.documentElement.dataset.theme !== "dark"));
    on("help-button", () => $("help").showModal());
    $("speed").addEventListener("change", event => {
      clock.speed = Number(event.target.value);
      clock.onChange();
    });
    $("follow").addEventListener("change", event => this.follow(event.target.value));
    $("watch").addEventListener("change", event => this.chooseWatch(this.watches[event.target.value]));
    // A button pressed with the mouse gives the keys back to the page, so that space plays.
    document.addEventListener("click", event => {
      if (event.detail > 0) event.target.closest("button")?.blur();
    });
  }

  toggle() {
    if (this.clock.isPlaying) this.clock.pause();
    else this.clock.play();
  }

  /** To the next (1) or previous (-1) event. While playing, "previous" skips what was just passed. */
  jump(direction) {
    const { time, speed, isPlaying, duration } = this.clock;
    if (direction > 0) {
      this.clock.seek(this.eventList.after(time) ?? duration);
    } else {
      const grace = isPlaying ? 0.5 * speed : 0;
      this.clock.seek(this.eventList.before(time - grace) ?? 0);
    }
  }

  fit() {
    this.follow("");
    this.camera.fit();
    this.refresh();
  }

  zoom(factor, px, py) {
    this.camera.zoom(factor, px, py);
    this.refresh();
  }

  #wireKeys() {
    const { clock } = this;
    const followNext = () => {
      const names = ["", ...this.bodies.keys()];
      this.follow(names[(names.indexOf(this.followed?.name ?? "") + 1) % names.length]);
    };
    const actions = {
      " ": () => this.toggle(),
      ArrowLeft: event => clock.seek(clock.time - (event.shiftKey ? 10 : 1)),
      ArrowRight: event => clock.seek(clock.time + (event.shiftKey ? 10 : 1)),
      Home: () => clock.seek(0),
      End: () => clock.seek(clock.duration),
      n: () => this.jump(1),
      p: () => this.jump(-1),
      "+": () => clock.changeSpeed(1),
      "=": () => clock.changeSpeed(1),
      "-": () => clock.changeSpeed(-1),
      f: followNext,
      0: () => this.fit(),
      "?": () => $("help").showModal(),
    };
    document.addEventListener("keydown", event => {
      if (event.ctrlKey || event.metaKey || event.altKey || $("help").open) return;
      if (CONTROL_KEYS.includes(event.key) && event.target.matches("select, button:focus-visible")) return;
      const action = actions[event.key];
      if (!action) return;
      event.preventDefault();
      action(event);
    });
  }

  #wireFloor() {
    const canvas = $("floor");
    const pointers = new Map();
    const place = event => [event.offsetX, event.offsetY];
    const spread = ([[ax, ay], [bx, by]]) => ({
      x: (ax + bx) / 2, y: (ay + by) / 2, width: Math.hypot(ax - bx, ay - by),
    });

    canvas.addEventListener("pointerdown", event => {
      canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, place(event));
    });
    canvas.addEventListener("pointermove", event => {
      if (!pointers.has(event.pointerId)) {
        this.#hintFloor(event);
        return;
      }
      hideHint();
      const before = [...pointers.values()];
      pointers.set(event.pointerId, place(event));
      const after = [...pointers.values()];
      if (after.length === 1) {
        this.#pan(after[0][0] - before[0][0], after[0][1] - before[0][1]);
      } else if (after.length === 2) {
        const [from, to] = [spread(before), spread(after)];
        this.#pan(to.x - from.x, to.y - from.y);
        if (from.width > 0) this.zoom(to.width / from.width, to.x, to.y);
      }
    });
    for (const type of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(type, event => pointers.delete(event.pointerId));
    }
    canvas.addEventListener("pointerleave", hideHint);
    canvas.addEventListener("wheel", event => {
      event.preventDefault();
      const pixels = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1);
      const rate = event.ctrlKey ? 0.01 : 0.0015;      // a pinch on a touchpad comes as ctrl and wheel
      this.zoom(Math.exp(-pixels * rate), ...place(event));
    }, { passive: false });
  }

  #pan(dx, dy) {
    if (this.followed && Math.hypot(dx, dy) > 0) this.follow("");
    this.camera.pan(dx, dy);
    this.refresh();
  }

  /** What is under the pointer, with its figures. */
  #hintFloor(event) {
    const [x, y] = this.camera.toFloor(event.offsetX, event.offsetY);
    const t = this.clock.time;
    const body = this.scene.bodyAt(t, x, y, Math.max(0.5, 12 / this.camera.scale));
    const obstacle = this.layer.obstacleAt(x, y);
    if (body) {
      const state = body.motion.at(t);
      const place = `(${fixed(state.x, 2)}, ${fixed(state.y, 2)})`;
      showHint(event, spoken(body.name), `${place}, ${fixed(state.speed, 2)} m/s`);
    } else if (obstacle) {
      showHint(event, spoken(obstacle.name), `${obstacle.bottom} to ${obstacle.top} m high`,
        `at (${fixed(x, 2)}, ${fixed(y, 2)})`);
    } else {
      hideHint();
    }
  }

  #wireChart() {
    const element = $("chart");
    const { chart, clock } = this;
    let pressedAt = 0;
    element.addEventListener("pointerdown", event => {
      element.setPointerCapture(event.pointerId);
      this.isScrubbing = true;
      pressedAt = event.offsetX;
      clock.seek(chart.markAt(event.offsetX, event.offsetY)?.event.t ?? chart.toTime(event.offsetX));
    });
    element.addEventListener("pointermove", event => {
      const isDragged = Math.abs(event.offsetX - pressedAt) > CLICK_TREMOR;
      if (this.isScrubbing && isDragged) clock.seek(chart.toTime(event.offsetX));
      this.#hintChart(event);
    });
    for (const type of ["pointerup", "pointercancel"]) {
      element.addEventListener(type, () => { this.isScrubbing = false; });
    }
    element.addEventListener("pointerleave", hideHint);
  }

  #hintChart(event) {
    const mark = this.chart.markAt(event.offsetX, event.offsetY);
    if (mark) {
      showHint(event, seconds(mark.event.t), mark.look.words, detailOf(mark.event));
      return;
    }
    const t = this.chart.toTime(event.offsetX);
    const now = this.watch?.at(t);
    const figures = now ? ["distance", "required", "margin"].map(name => `${name} ${metres(now[name])}`) : [];
    showHint(event, seconds(t), ...figures);
  }
}

/** Lines of text beside the pointer. */
function showHint(event, ...lines) {
  const hint = $("hint");
  if (event.pointerType === "touch") return;
  hint.hidden = false;
  hint.textContent = lines.filter(Boolean).join("\n");
  const { width, height } = hint.getBoundingClientRect();
  const x = Math.min(event.clientX + 14, innerWidth - width - 6);
  const y = event.clientY + 16 + height > innerHeight ? event.clientY - height - 12 : event.clientY + 16;
  hint.style.transform = `translate(${x}px, ${y}px)`;
}

function hideHint() {
  $("hint").hidden = true;
}

function showTrouble(why) {
  const problems = why instanceof RecordingError ? why.problems : [`unexpected: ${why.message}`];
  const shown = problems.slice(0, MOST_PROBLEMS);
  if (problems.length > shown.length) shown.push(`… and ${problems.length - shown.length} more`);
  $("trouble").querySelector("ul").append(...shown.map(problem => element("li", { text: problem })));
  $("trouble").hidden = false;
  $("replay").hidden = true;
}

document.addEventListener("DOMContentLoaded", () => {
  try {
    const recording = readRecording();
    $("replay").hidden = false;
    const replay = new Replay(recording);
    /**
     * For scripts and tests. `watch` is a place in recording.watches; times are seconds.
     *   pose(body, t)        -> {x, y, rotation, vx, vy, speed}
     *   separation(watch, t) -> {distance, required, margin, notice, personSpeed, otherSpeed, violated}
     */
    window.floorwalker = {
      recording,
      get time() { return replay.clock.time; },
      seek: t => replay.clock.seek(t),
      play: () => replay.clock.play(),
      pause: () => replay.clock.pause(),
      pose: (body, t) => replay.bodies.get(body).motion.at(t),
      separation: (watch, t) => replay.watches[watch].at(t),
    };
  } catch (why) {
    showTrouble(why);
  }
});
