/* The list of events. */

/** The list of events, a button each; the latest one is marked and kept in view. */
class EventList {
  constructor(list, onChoose) {
    this.list = list;
    this.onChoose = onChoose;
    this.times = [];
    this.items = [];
    this.current = -1;
    this.isHeld = false;       // no scrolling while the pointer is over the list
    list.addEventListener("pointerenter", event => { this.isHeld = event.pointerType === "mouse"; });
    list.addEventListener("pointerleave", () => { this.isHeld = false; });
  }

  /** Shows these events, which begin with those that are listed already. */
  extend(events, bodies) {
    const more = events.slice(this.items.length).map(event => this.#item(event, bodies));
    this.items.push(...more);
    this.times = events.map(event => event.t);
    this.list.append(...more);
  }

  #item(event, bodies) {
    const look = lookOf(event, bodies);
    const words = element("span", { text: look.words });
    const detail = detailOf(event);
    if (detail) words.append(element("small", { text: detail }));
    const button = element("button", { type: "button" },
      element("time", { text: fixed(event.t, 2) }), element("span", {}, glyphElement(look)), words);
    button.addEventListener("click", () => this.onChoose(event.t));
    return element("li", {}, button);
  }

  show(t) {
    const current = lastUpTo(this.times, t + 1e-9);
    if (current === this.current) return;
    this.items[this.current]?.removeAttribute("aria-current");
    this.current = current;
    const item = this.items[current];
    item?.setAttribute("aria-current", "true");
    if (!this.isHeld) this.#keepInView(item);
  }

  /** Scroll the list, and never the page. */
  #keepInView(item) {
    const { list } = this;
    if (!item) list.scrollTop = 0;
    else if (item.offsetTop < list.scrollTop + 30) list.scrollTop = item.offsetTop - 60;
    else if (item.offsetTop + item.offsetHeight > list.scrollTop + list.clientHeight - 60) {
      list.scrollTop = item.offsetTop + item.offsetHeight - list.clientHeight + 60;
    }
  }

  /** The time of the next event after t, or of the last one before it. */
  after(t) {
    return this.times[lastUpTo(this.times, t + 1e-9) + 1];
  }

  before(t) {
    return this.times[lastBefore(this.times, t - 1e-9)];
  }
}
