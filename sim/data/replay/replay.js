/* The page: one run or two beside each other, one clock, one chosen pair. */

const CONTROL_KEYS = [" ", "ArrowLeft", "ArrowRight", "Home", "End"];    // keys with a meaning in controls
const NARROWEST_FLOOR = 500;       // CSS pixels of the floor's panel
const BROAD_SIDE = 740;            // CSS pixels beside the floor, from which two columns stand there
const TURN_OF_KEY = 20;            // pixels of a drag that a key stands for
const PLAY = "M4 2.5v11L13.5 8z";
const PAUSE = "M3.5 2.5h3v11h-3zm6 0h3v11h-3z";

class Replay {
  constructor(run) {
    this.runs = [];
    this.views = [];
    this.readouts = [];
    this.panels = [];
    this.focus = 0;            // the run whose panels are shown
    this.choice = 0;           // the watch of the first run that is in focus
    this.followed = "";
    this.isInSpace = this.isInEyes = false;
    this.control = null;       // of a run under way
    this.field = "";           // the kind of field that is shown
    this.clock = new Clock(run.duration, () => this.refresh());
    this.chart = new Chart($("chart"), () => this.#resize());
    for (const speed of SPEEDS) this.#offerSpeed(speed);
    this.#add(run);
    this.choose(run.firstWatch);
    this.#wireButtons();
    this.#wireKeys();
    this.#wireChart();
    addEventListener("resize", () => this.#layOut());
    const systemIsDark = matchMedia("(prefers-color-scheme: dark)");
    systemIsDark.addEventListener("change", () => this.setTheme(systemIsDark.matches));
    this.setTheme(systemIsDark.matches);
  }

  // ---- runs

  /** Shows another run beside the first one, instead of any that is there. */
  compare(run) {
    this.stopComparing();
    this.#add(run);
    this.focusOn(0);
    this.#showRuns();
  }

  stopComparing() {
    for (const part of [this.views, this.readouts, this.panels, this.runs]) part.length = 1;
    for (const place of ["views", "readouts", "panels"]) {
      while ($(place).children.length > 1) $(place).lastElementChild.remove();
    }
    this.focusOn(0);
    this.#showRuns();
  }

  /** The first run has grown. */
  grow(run) {
    this.runs[0] = run;
    this.views[0].show(run);
    this.#showRuns();
    this.control?.show();
  }

  #add(run) {
    const letter = LETTERS[this.runs.length];
    const frame = stamp("view");
    frame.querySelector(".letter").textContent = letter;
    $("views").append(frame);
    const on = {
      pan: (dx, dy) => this.#pan(dx, dy),
      zoom: (factor, px, py) => this.zoom(factor, px, py),
      orbit: (dx, dy) => this.orbit(dx, dy),
      point: (view, event) => {
        const at = [event.offsetX, event.offsetY];
        showHint(event, ...view.describe(...at, this.clock.time), ...this.#fieldAt(view, ...at));
      },
      pick: (view, bodyAt) => this.#pick(view, bodyAt(this.clock.time)),
      grab: (view, px, py) => this.control?.grab(view, px, py),
    };
    const view = new Views(run, frame, on, () => this.#resize());
    const readout = new Readout(letter);
    const panels = new Panels(t => this.clock.seek(t));
    $("readouts").append(readout.root);
    $("panels").append(panels.root);
    this.runs.push(run);
    this.views.push(view);
    this.readouts.push(readout);
    this.panels.push(panels);
    if (this.isInSpace) this.showSpace(true);
    this.#showRuns();
  }

  /** Shows what does not depend on time. */
  #showRuns() {
    const [first] = this.runs;
    const { floorplan, bodies, title } = first.recording;
    const people = castOf(bodies.filter(body => body.personality));
    const isCompared = this.runs.length > 1;
    const names = namesOf(this.runs);
    this.views.forEach((view, i) => { view.frame.querySelector(".title").textContent = names[i]; });
    document.body.classList.toggle("compared", isCompared);
    document.body.classList.toggle("unwatched", first.watches.length === 0);
    document.querySelector("#legend .of-speed b").textContent = first.people.length ? "people" : "machines";
    $("title").textContent = isCompared ? names.map((name, i) => `${LETTERS[i]}: ${name}`).join("; ") : title ?? "";
    $("subtitle").textContent = isCompared
      ? "" : [floorplan.title, ...people].filter(Boolean).join(" · ");
    $("focus").replaceChildren(...namesOf(this.runs, 1).map((name, i) => this.#focusButton(name, i)));
    const duration = Math.max(...this.runs.map(run => run.duration));
    document.body.classList.toggle("long", duration >= LONG);
    this.clock.duration = duration;
    this.clock.frontier = first.known < first.duration ? first.known : duration;
    $("clock-end").textContent = `/ ${duration < LONG ? `${+duration.toFixed(2)} s` : clockTime(duration, 0)}`;
    $("chart").setAttribute("aria-valuemax", duration);
    this.#offer($("follow"), bodies.map(({ name }) => [name, spoken(name)]), 1);
    this.#offer($("watch"), first.watches.map((watch, i) => [i, watch.name]), 0);
    this.panels.forEach((panels, i) => panels.fill(this.runs[i], this.runs));
    if (!this.isInSpace) this.#say("");
    this.chart.show(this.runs);
    showKinds($("kinds"), this.runs);
    this.#layOut();
    this.redraw();
  }

  /**
   * Gives the floor as much room as it fills at the height of the window; where two columns of panels fit beside
   * it, they stand there, and the plot below all.
   */
  #layOut() {
    const { left, right, bottom, top } = this.views[0].above.camera.bounds;
    const wide = () => Math.max($("views").clientHeight * (right - left) / (top - bottom), NARROWEST_FLOOR);
    const isBroad = !this.isInSpace && this.runs.length === 1 && innerWidth > 860 && innerWidth - wide() >= BROAD_SIDE;
    document.body.classList.toggle("broad", isBroad);
    document.documentElement.style.setProperty("--stage", `${Math.round(wide())}px`);
  }

  /** Fills a list of options after the first `kept` ones; the selected one stays. */
  #offer(select, options, kept) {
    if (select.options.length === options.length + kept) return;
    select.length = kept;
    select.append(...options.map(([value, text]) => element("option", { value, text })));
  }

  #focusButton(name, i) {
    const button = element("button", { type: "button", text: `${LETTERS[i]} ${name}`, title: name });
    button.ariaPressed = String(i === this.focus);
    button.addEventListener("click", () => this.focusOn(i));
    return button;
  }

  /** Show the panels of the run with that number. */
  focusOn(i) {
    this.focus = i;
    this.panels.forEach((panels, k) => { panels.root.hidden = k !== i; });
    [...$("focus").children].forEach((button, k) => { button.ariaPressed = String(k === i); });
    this.refresh();
  }

  // ---- the chosen pair

  get watches() {
    const chosen = this.runs[0].watches[this.choice];
    return this.runs.map((run, i) => (i === 0 ? chosen : run.watchLike(chosen)));
  }

  /** The person in focus, and the machine: that of the pair, or the first one. */
  get chosenPerson() {
    return this.#person(this.runs[0], this.watches[0]);
  }

  get chosenMachine() {
    const other = this.watches[0]?.other;
    const machines = [...this.runs[0].bodies.values()].filter(body => body.category !== "person");
    return machines.includes(other) ? other : machines[0];
  }

  /** The person whose mind is shown. */
  #person(run, watch) {
    return watch?.person ?? run.people[0];
  }

  choose(index) {
    this.choice = index;
    $("watch").value = index;
    const [watch] = this.watches;
    const shown = watch?.person ?? this.runs[0].paced[0];
    if (shown) document.documentElement.style.setProperty("--shown", `var(--${shown.color})`);
    document.body.classList.toggle("of-people", watch?.isOfPeople ?? false);
    if (this.isInEyes) this.lookThrough(true);
    this.control?.show();
    this.redraw();
  }

  /** A click on a person or a machine chooses it for the pair. */
  #pick(view, body) {
    this.focusOn(this.views.indexOf(view));
    if (!body) return;
    const { watches } = this.runs[0];
    const current = watches[this.choice];
    const person = body.category === "person" ? body.name : current?.person.name;
    const other = body.category === "person" ? current?.other.name : body.name;
    const index = watches.findIndex(watch => watch.person.name === person && watch.other.name === other);
    if (index >= 0) this.choose(index);
  }

  follow(name) {
    this.followed = name;
    for (const view of this.views) view.follow(name);
    $("follow").value = name;
    if (this.isInEyes) this.lookThrough(true);
    this.refresh();
  }

  fit() {
    this.follow("");
    for (const view of this.views) view.camera.fit();
    this.refresh();
  }

  zoom(factor, px, py) {
    for (const view of this.views) view.camera.zoom(factor, px, py);
    this.refresh();
  }

  #pan(dx, dy) {
    if (this.followed && Math.hypot(dx, dy) > 0) this.follow("");
    for (const view of this.views) view.camera.pan(dx, dy);
    this.refresh();
  }

  // ---- three dimensions

  /** Shows the floor in three dimensions, or from above. */
  showSpace(isWanted) {
    try {
      for (const view of this.views) view.showSpace(isWanted, () => this.#loseSpace());
      this.#say("");
    } catch (why) {
      this.#loseSpace();
      console.info(why);
      return;
    }
    this.isInSpace = isWanted;
    this.#layOut();
    if (this.followed) this.follow(this.followed);
    this.lookThrough(this.isInEyes && isWanted);
    this.redraw();
  }

  /** The browser has no WebGL 2, or takes it away. */
  #loseSpace() {
    for (const view of this.views) view.loseSpace();
    this.isInSpace = this.isInEyes = false;
    this.#layOut();
    this.#say(WITHOUT_WEBGL);
    this.lookThrough(false);
    this.redraw();
  }

  /** A line over the floor. */
  #say(words) {
    const lines = [...new Set(this.runs.flatMap(run => run.recording.notices ?? [])), words].filter(Boolean);
    $("notice").hidden = lines.length === 0;
    write($("notice"), lines.join("\n"));
  }

  /** Looks through the eyes of the followed person, or else of the chosen one; or from outside again. */
  lookThrough(isWanted) {
    this.isInEyes = isWanted;
    if (isWanted && !this.isInSpace) {
      this.showSpace(true);
      return;
    }
    const people = this.views.map((view, i) => {
      const followed = view.run.bodies.get(this.followed);
      return followed?.category === "person" ? followed : this.#person(view.run, this.watches[i]);
    });
    this.views.forEach((view, i) => view.lookThrough(isWanted ? people[i] ?? null : null));
    $("flat").ariaPressed = String(!this.isInSpace);
    $("space").ariaPressed = String(this.isInSpace && !isWanted);
    $("eyes").ariaPressed = String(isWanted);
    $("scale").style.visibility = this.isInSpace ? "hidden" : "";
    this.refresh();
  }

  /** Shows the floor alone, with the time, for a film that goes `speed` times as fast as in reality. */
  film({ view, speed, follow = "" }) {
    this.filmSpeed = speed;
    document.body.classList.add("filming");
    $("instant").hidden = false;
    this.showSpace(view !== "2d");
    if (view !== "2d" && !this.isInSpace) throw new Error(WITHOUT_WEBGL);
    this.follow(follow);
    if (view === "eyes") this.lookThrough(true);
    this.redraw();
  }

  orbit(dx, dy) {
    if (!this.isInSpace) return;
    for (const view of this.views) view.camera.orbit(dx, dy);
    this.refresh();
  }

  // ---- time

  toggle() {
    if (this.clock.isPlaying) this.clock.pause();
    else this.clock.play();
  }

  /** To the next (1) or previous (-1) event. While playing, "previous" skips one that was just passed. */
  jump(direction) {
    const { time, speed, isPlaying, frontier } = this.clock;
    const { events } = this.panels[this.focus];
    if (direction > 0) {
      this.clock.seek(events.after(time) ?? frontier);
    } else {
      const grace = isPlaying ? 0.5 * speed : 0;
      this.clock.seek(events.before(time - grace) ?? 0);
    }
  }

  // ---- drawing

  setTheme(dark) {
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    this.palette = readPalette();
    this.redraw();
  }

  /** Redraws everything: sizes, colours or the watch have changed. */
  redraw() {
    this.isStale = true;
    this.refresh();
  }

  /** Redraws at once, and not one frame later: a canvas of a new size is empty. */
  #resize() {
    this.isStale = true;
    this.#draw();
  }

  /** Asks for a frame, unless one is coming anyway. */
  refresh() {
    this.frame ??= requestAnimationFrame(now => this.#drawFrame(now));
  }

  #drawFrame(now) {
    this.frame = null;
    const { clock } = this;
    if (clock.isPlaying && !this.isScrubbing) clock.advance((now - (this.lastFrame ?? now)) / 1000);
    this.lastFrame = clock.isPlaying ? now : undefined;
    this.#draw();
    if (clock.isPlaying) this.refresh();
  }

  #draw() {
    const { clock, watches } = this;
    const hasMoved = clock.time !== this.shownTime && !this.isScrubbing;
    this.shownTime = clock.time;
    if (hasMoved && this.chart.keepInView(clock.time)) this.isStale = true;
    if (this.isStale) {
      this.isStale = false;
      this.#scaleField();
      for (const view of this.views) view.restyle(this.palette);
      this.chart.draw(watches, this.palette);
    }
    const t = clock.time;
    this.runs.forEach((run, i) => {
      this.views[i].draw(t, watches[i], this.#afterglow);
      this.control?.draw(this.views[i]);
      this.readouts[i].show(run, watches[i], watches[0], t, this.#afterglow);
    });
    const shown = this.runs[this.focus];
    this.panels[this.focus].show(shown, this.#person(shown, watches[this.focus]), t);
    this.chart.moveCursor(t);
    showScale($("scale"), this.views[0].camera.scale);
    this.#showClock(t);
  }

  /** Gives the field that is shown one scale in all views. */
  #scaleField() {
    const isDark = document.documentElement.dataset.theme === "dark";
    this.fieldScale = this.field ? new FieldScale(this.field, this.runs, isDark) : null;
    for (const view of this.views) view.showField(this.fieldScale);
    showFieldScale($("field-scale"), this.fieldScale);
  }

  /** The field at a place of the floor that is pointed at, in words; [] where none is shown. */
  #fieldAt(view, px, py) {
    const place = this.fieldScale && view.camera.onFloor(px, py);
    const found = place && view.run.fields.valueAt(this.field, this.clock.time, ...place);
    return found?.density > FAINT ? [`${fixed(found.value, 2)} ${FIELDS[this.field].unit}`] : [];
  }

  /** Seconds of the recording for which what was over at once is still shown. */
  get #afterglow() {
    if (this.filmSpeed) return Math.max(AFTERGLOW, FILMED * this.filmSpeed);
    return Math.max(AFTERGLOW, this.clock.isPlaying ? GLIMPSE * this.clock.speed : 0);
  }

  #showClock(t) {
    const { clock } = this;
    write($("clock-time"), seconds(t));
    if (this.filmSpeed) write($("instant"), seconds(t));
    const chart = $("chart");
    chart.setAttribute("aria-valuenow", t.toFixed(2));
    if ($("play").dataset.playing !== String(clock.isPlaying)) {
      $("play").dataset.playing = clock.isPlaying;
      $("play").setAttribute("aria-label", clock.isPlaying ? "Pause" : "Play");
      $("play").querySelector("path").setAttribute("d", clock.isPlaying ? PAUSE : PLAY);
    }
    if (Number($("speed").value) !== clock.speed) {
      this.#offerSpeed(clock.speed);
      $("speed").value = clock.speed;
    }
    if ($("live").ariaPressed !== String(clock.isLive)) $("live").ariaPressed = String(clock.isLive);
    if (clock.isPlaying) return;
    chart.setAttribute("aria-valuetext", `${t.toFixed(1)} seconds`);
    for (const view of this.views) view.canvas.setAttribute("aria-label", view.inWords(t));
  }

  // ---- controls

  /** Adds a speed to the list, in its place, unless it is there. */
  #offerSpeed(speed) {
    const next = [...$("speed").options].find(option => Number(option.value) >= speed);
    if (next && Number(next.value) === speed) return;
    $("speed").add(element("option", { value: speed, text: `${speed}×` }), next ?? null);
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
    on("flat", () => this.showSpace(false));
    on("space", () => {
      this.isInEyes = false;
      this.showSpace(true);
    });
    on("eyes", () => this.lookThrough(!this.isInEyes));
    on("live", () => clock.goLive());
    on("theme", () => this.setTheme(document.documentElement.dataset.theme !== "dark"));
    on("help-button", () => $("help").showModal());
    on("stop-comparing", () => this.stopComparing());
    $("speed").addEventListener("change", event => {
      clock.goAt(Number(event.target.value));
    });
    $("follow").addEventListener("change", event => this.follow(event.target.value));
    $("field").addEventListener("change", event => {
      this.field = event.target.value;
      this.redraw();
    });
    $("watch").addEventListener("change", event => this.choose(Number(event.target.value)));
    // A button pressed with the mouse gives the keys back to the page, so that space plays.
    document.addEventListener("click", event => {
      if (event.detail > 0) event.target.closest("button")?.blur();
    });
  }

  #wireKeys() {
    const { clock } = this;
    const followNext = () => {
      const names = ["", ...this.runs[0].bodies.keys()];
      this.follow(names[(names.indexOf(this.followed) + 1) % names.length]);
    };
    const actions = {
      " ": () => this.toggle(),
      ArrowLeft: event => clock.seek(clock.time - (event.shiftKey ? 10 : 1)),
      ArrowRight: event => clock.seek(clock.time + (event.shiftKey ? 10 : 1)),
      Home: () => clock.seek(0),
      End: () => clock.seek(clock.frontier),
      n: () => this.jump(1),
      p: () => this.jump(-1),
      "+": () => clock.faster(),
      "=": () => clock.faster(),
      "-": () => clock.slower(),
      f: followNext,
      0: () => this.fit(),
      3: () => this.showSpace(!this.isInSpace),
      e: () => this.lookThrough(!this.isInEyes),
      a: () => this.orbit(-TURN_OF_KEY, 0),
      d: () => this.orbit(TURN_OF_KEY, 0),
      w: () => this.orbit(0, TURN_OF_KEY),
      s: () => this.orbit(0, -TURN_OF_KEY),
      "?": () => $("help").showModal(),
    };
    document.addEventListener("keydown", event => {
      if (event.ctrlKey || event.metaKey || event.altKey || $("help").open) return;
      // What had the focus in a dialog keeps it until the frame after the dialog has closed.
      const inControl = event.target.matches("select, button:focus-visible")
        && !event.target.closest("dialog:not([open])");
      if (CONTROL_KEYS.includes(event.key) && inControl) return;
      const action = actions[event.key];
      if (!action) return;
      event.preventDefault();
      action(event);
    });
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
    element.addEventListener("wheel", event => {
      event.preventDefault();
      const sideways = event.shiftKey ? event.deltaX || event.deltaY : event.deltaX;
      if (Math.abs(sideways) > Math.abs(event.deltaY) || event.shiftKey) chart.shift(sideways);
      else chart.zoom(zoomFactor(event), event.offsetX);
      this.redraw();
    }, { passive: false });
    element.addEventListener("dblclick", () => {
      chart.showAll();
      this.redraw();
    });
  }

  #hintChart(event) {
    const mark = this.chart.markAt(event.offsetX, event.offsetY);
    if (mark) {
      showHint(event, seconds(mark.event.t), mark.look.words, detailOf(mark.event));
      return;
    }
    const t = this.chart.toTime(event.offsetX);
    const { watches } = this;
    const figures = watches.map((watch, i) => {
      const figures = watch?.at(t);
      const words = !watch ? [] : ["distance", "required", "margin"]
        .map(name => `${watch.words[name]} ${metres(figures[name])}`);
      if (this.runs.length > 1) words.unshift(`${[LETTERS[i], pairOf(watch, watches[0])].filter(Boolean).join(" ")}:`);
      return words.join("\n");
    });
    showHint(event, seconds(t), ...figures);
  }
}
