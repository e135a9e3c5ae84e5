/* The list of events. */

const MOST_ITEMS = 600;        // of the events, that many round the latest one are in the page

/**
 * The list of events, a button each; the latest one is marked and kept in view. Of very many events the
 * list holds those round the latest one, or round the place to which it is scrolled.
 */
class EventList {
  constructor(list, onChoose) {
    this.list = list;
    this.onChoose = onChoose;
    this.times = [];
    this.items = [];           // the elements of the events from number `first` on
    this.first = 0;
    this.current = -1;
    this.isHeld = false;       // no scrolling while the pointer is over the list
    list.addEventListener("pointerenter", event => { this.isHeld = event.pointerType === "mouse"; });
    list.addEventListener("pointerleave", () => { this.isHeld = false; });
    list.addEventListener("scroll", () => this.#scrolled());
  }

  /** Shows these events, which begin with those that are listed already. */
  extend(events, bodies) {
    Object.assign(this, { events, bodies, times: events.map(event => event.t) });
    const end = this.first + this.items.length;
    const more = events.slice(end, this.first + MOST_ITEMS).map(event => this.#item(event, bodies));
    this.items.push(...more);
    this.list.append(...more);
  }

  /** Puts the events round the one of that number into the list, instead of those in it. */
  #hold(number) {
    const last = Math.max(0, this.events.length - MOST_ITEMS);
    this.first = Math.min(Math.max(0, number - MOST_ITEMS / 2), last);
    this.items = this.events.slice(this.first, this.first + MOST_ITEMS).map(event => this.#item(event, this.bodies));
    this.list.replaceChildren(...this.items);
    this.#currentItem?.setAttribute("aria-current", "true");
  }

  get #currentItem() {
    return this.items[this.current - this.first];
  }

  /** Near an end of what the list holds, takes more; the events that are seen stay where they are. */
  #scrolled() {
    const { list, items, first } = this;
    const room = list.clientHeight;
    const isAtTop = list.scrollTop < room && first > 0;
    const isAtEnd = list.scrollTop + 2 * room > list.scrollHeight && first + items.length < this.times.length;
    if (!isAtTop && !isAtEnd) return;
    const seen = items.findIndex(item => item.offsetTop + item.offsetHeight > list.scrollTop);
    const number = first + Math.max(0, seen);
    const above = list.scrollTop - items[number - first].offsetTop;
    this.#hold(number);
    list.scrollTop = this.items[number - this.first].offsetTop + above;
  }

  #item(event, bodies) {
    const look = lookOf(event, bodies);
    const words = element("span", { text: look.words });
    const detail = detailOf(event);
    if (detail) words.append(element("small", { text: detail }));
    const button = element("button", { type: "button" },
      element("time", { text: clockTime(event.t, 2) }), element("span", {}, glyphElement(look)), words);
    button.addEventListener("click", () => this.onChoose(event.t));
    return element("li", {}, button);
  }

  show(t) {
    const current = lastUpTo(this.times, t + 1e-9);
    if (current === this.current) return;
    this.#currentItem?.removeAttribute("aria-current");
    this.current = current;
    if (current >= 0 && !this.#currentItem) this.#hold(current);
    this.#currentItem?.setAttribute("aria-current", "true");
    if (!this.isHeld) this.#keepInView(this.#currentItem);
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
