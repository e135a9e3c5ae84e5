/* The texts about one run: the mind in focus, the events, the summary. */

const ROOM_FOR_ALL = 1100;     // pixels of height from which the summary is unfolded, too

/** The panels of one run, side by side with those of another or alone. */
class Panels {
  constructor(onChoose) {
    this.root = stamp("panels-of-one");
    this.onChoose = onChoose;
    this.mind = new MindPanel(this.root.querySelector(".mind"));
    this.events = new EventList(this.root.querySelector(".events ol"), onChoose);
    for (const section of this.root.children) this.#makeFoldable(section);
    if (innerHeight < ROOM_FOR_ALL && innerWidth > 860) this.#fold(this.root.querySelector(".summary"), true);
  }

  /** The events of a run, which may have grown, and the summaries of all. */
  fill(run, all) {
    this.events.extend(run.events, run.bodies);
    const summaries = all.map(one => one.recording.summary ?? {});
    showSummaries(this.root.querySelector(".summary .body"), summaries, this.onChoose);
  }

  show(run, person, t) {
    this.mind.show(run, person, t);
    this.events.show(t);
  }

  #makeFoldable(section) {
    const button = section.querySelector("h2 button");
    button.addEventListener("click", () => this.#fold(section, button.ariaExpanded === "true"));
  }

  #fold(section, isFolded) {
    section.querySelector("h2 button").ariaExpanded = String(!isFolded);
    section.querySelector(".body").hidden = isFolded;
  }
}
