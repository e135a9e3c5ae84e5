/* Control of a run under way: pause, speed, and what is done in it from the page. */

const BOX = 1;                 // metres of a box that a click puts down
const SMALLEST_BOX = 0.1;      // metres that have to be drawn for another one
const GRAIN = 100;             // places are given to a hundredth of a metre
const HINTS = {
  send: "Click where to; or arrow keys and Enter. Esc ends it.",
  block: "Draw a box, or click; a click on one takes it up. Or arrow keys, Shift for its size, Enter. Esc ends it.",
};

class Control {
  constructor(replay) {
    Object.assign(this, { replay, tool: null, drawn: null, isPaused: false });
    $("control").hidden = false;
    document.body.classList.add("controlled");
    replay.control = this;
    this.placing = new Placing($("placing"), {
      move: words => {
        this.#say(words);
        replay.refresh();
      },
      put: () => this.#put(...this.placing.corners, true),
    });
    replay.clock.steer = speed => this.#ask({ pace: { speed } });
    const on = (id, action) => $(id).addEventListener("click", action);
    on("pause-run", () => this.#ask({ pace: { paused: !this.isPaused } }));
    on("send", () => this.take("send"));
    on("block", () => this.take("block"));
    on("hold", () => this.#command({ [this.#isHeld ? "release" : "hold"]: replay.chosenMachine.name }));
    $("destination").addEventListener("change", event => this.#send(event.target.value));
    $("clear").addEventListener("change", event => this.#command({ clear: event.target.value }));
    document.addEventListener("keydown", event => {
      if (event.key === "Escape" && this.tool) this.take(null);
    });
    this.show();
  }

  /** Takes a tool for the floor into the hand, or (null, or the one that is there) none. */
  take(tool) {
    const last = this.tool;
    this.tool = tool === last ? null : tool;
    document.body.classList.toggle("armed", this.tool !== null);
    const byKey = document.activeElement?.matches("#control :focus-visible");
    if (this.tool) this.placing.begin(this.replay, this.tool === "block");
    if (byKey) $(this.tool ? "placing" : last ?? "block").focus();
    if (!this.tool) this.placing.end();
    this.#say(HINTS[this.tool] ?? "");
    this.show();
    this.replay.refresh();
  }

  /** The run goes on like that: {speed, paused}; a speed of 0 is none in particular. */
  keepPace({ speed, paused }) {
    const { clock } = this.replay;
    this.isPaused = paused;
    clock.runSpeed = speed || clock.runSpeed;
    if (clock.isLive) clock.speed = clock.runSpeed;
    clock.onChange();
    this.show();
  }

  /** Shows what can be done to whom now. */
  show() {
    const { chosenPerson, chosenMachine, runs: [run] } = this.replay;
    const press = (id, isPressed, words) => {
      $(id).ariaPressed = String(isPressed);
      write($(id), words);
    };
    press("pause-run", this.isPaused, this.isPaused ? "Resume run" : "Pause run");
    $("send").hidden = !chosenPerson;
    $("hold").hidden = !chosenMachine;
    if (chosenPerson) press("send", this.tool === "send", `Send ${spoken(chosenPerson.name)}`);
    press("block", this.tool === "block", "Block");
    if (chosenMachine) press("hold", this.#isHeld, `${this.#isHeld ? "Release" : "Hold"} ${spoken(chosenMachine.name)}`);
    this.#offer("destination", "to …", run.plan.stations.map(({ name }) => name), this.tool === "send");
    const placed = run.placedAt(run.known).map(({ name }) => name);
    this.#offer("clear", "Take up …", placed, placed.length > 0);
  }

  end() {
    this.take(null);
    $("control").hidden = true;
    document.body.classList.remove("controlled");
    this.replay.clock.steer = this.replay.control = null;
  }

  /** What a press at a pixel begins, if a tool is in the hand: {move, end, cancel}. */
  grab(view, px, py) {
    const from = this.tool && view.camera.onFloor(px, py);
    if (!from) return null;
    const reach = (x, y) => {
      const to = view.camera.onFloor(x, y);
      if (to) this.drawn = [from, to];
      this.replay.refresh();
    };
    reach(px, py);
    return {
      move: reach,
      end: () => {
        const [, to] = this.drawn;
        this.drawn = null;
        this.#put(from, to);
      },
      cancel: () => {
        this.drawn = null;
        this.replay.refresh();
      },
    };
  }

  /** Draws what is about to be put down, or the place to which somebody is sent. */
  draw(view) {
    const isHeld = document.activeElement === $("placing");
    const drawn = this.drawn ?? (this.placing.at && isHeld ? this.placing.corners : null);
    if (!drawn || (this.tool !== "block" && !isHeld)) return;
    const { context, palette } = view.shown.pen;
    const { x: [left, right], y: [bottom, top] } = this.tool === "block" ? boxBetween(...drawn) : spotAt(drawn[1]);
    const corners = [[left, bottom], [right, bottom], [right, top], [left, top]].map(([x, y]) => view.camera.toScreen(x, y, 0));
    if (corners.some(corner => !corner)) return;
    context.beginPath();
    for (const [px, py] of corners) context.lineTo(px, py);
    context.closePath();
    context.fillStyle = context.strokeStyle = palette.text;
    alpha(context, 0.25, () => context.fill());
    context.setLineDash([4, 3]);
    context.lineWidth = 1.5;
    context.stroke();
    context.setLineDash([]);
  }

  get #isHeld() {
    const { chosenMachine, runs: [run] } = this.replay;
    return chosenMachine && run.isHeld(chosenMachine, run.known);
  }

  #offer(id, title, names, isShown) {
    const select = $(id);
    select.hidden = !isShown;
    const wanted = [title, ...names.map(spoken)];
    if ([...select.options].map(option => option.text).join() !== wanted.join()) {
      select.replaceChildren(...wanted.map((text, i) => element("option", { text, value: names[i - 1] ?? "" })));
    }
    select.value = "";
  }

  /** Does with two corners what the tool is for; `byKey` a box already there is taken up, as by a click. */
  #put(from, to, byKey = false) {
    if (this.tool === "send") this.#send(to.map(toGrain));
    else this.#block(from, to, byKey || Math.hypot(to[0] - from[0], to[1] - from[1]) < SMALLEST_BOX);
  }

  #send(to) {
    this.#command({ send: this.replay.chosenPerson.name, to });
    if (this.tool) this.take(null);
  }

  /** Puts a box down, or takes up the one that was clicked. */
  #block(from, to, isClick) {
    const [run] = this.replay.runs;
    const box = boxBetween(from, to);
    const middle = [0, 1].map(side => (from[side] + to[side]) / 2);
    const there = isClick && run.placedAt(run.known).find(({ footprint }) => isInside(footprint, ...middle));
    this.#command(there ? { clear: there.name } : { block: run.freeName("box"), ...box });
  }

  #command(command) {
    return this.#ask({ command });
  }

  /** Asks the run for something, and says what is done, or why it can't be. */
  async #ask(wish) {
    try {
      const reply = await fetch("control", {
        method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(wish),
      });
      const { problem } = await reply.json();
      this.#say(problem ?? (wish.command ? `${commandWords(wish.command)}.` : HINTS[this.tool] ?? ""));
    } catch {
      this.#say("The run does not answer.");
    }
    this.replay.clock.onChange();
  }

  #say(words) {
    write($("control-status"), words);
  }
}

const toGrain = metres => Math.round(metres * GRAIN) / GRAIN;

/** A small box round a place. */
const spotAt = ([x, y]) => ({ x: [x - SMALLEST_BOX, x + SMALLEST_BOX], y: [y - SMALLEST_BOX, y + SMALLEST_BOX] });

/** The box between two points of the floor, as ranges; a small one round the first where they are one. */
function boxBetween([ax, ay], [bx, by]) {
  const range = (a, b) => (Math.hypot(ax - bx, ay - by) < SMALLEST_BOX
    ? [a - BOX / 2, a + BOX / 2] : [Math.min(a, b), Math.max(a, b)]).map(toGrain);
  return { x: range(ax, bx), y: range(ay, by) };
}
