// The history of edits with thumbnails, and two snapshots to compare.

import { make } from "./elements.js";

/** @typedef {import("./types.js").State} State */

const THUMBNAIL_WIDTH = 96;
const THUMBNAIL_HEIGHT = 54;
/** Number of edits that are listed at first; long sessions would fill the page. */
const LISTED_COUNT = 20;

/** Lists the edits, newest last. */
export class History {
  /** The rows by entry. @type {Map<number, {item: HTMLLIElement, button: HTMLButtonElement, picture: HTMLCanvasElement, label: HTMLElement}>} */
  #rows = new Map();
  #shown = "";
  /** Whether all edits are listed. */
  #all = false;

  /** @param {import("./session.js").Session} session @param {() => void} oncompare compares the picture with that of the style as opened */
  constructor(session, oncompare) {
    this.session = session;
    this.list = make("ol", { className: "history" });
    this.earlier = make("button", { type: "button", textContent: "Show earlier edits", hidden: true });
    this.earlier.addEventListener("click", () => {
      this.#all = true;
      this.#shown = "";
      if (session.state) this.show(session.state);
    });
    this.first = make("button", { type: "button", textContent: "Compare with the style as opened", hidden: true, onclick: oncompare });
    this.slots = make("div", { className: "slots" });
    this.element = make("div", {}, make("h2", { className: "minor", textContent: "Snapshots" }), this.slots, make("h2", { className: "minor", textContent: "Edits" }), this.first, this.earlier, this.list);
    for (const slot of /** @type {("a" | "b")[]} */ (["a", "b"])) {
      const keep = make("button", { type: "button", textContent: "Store", title: `Store the current state as snapshot ${slot.toUpperCase()} (Shift+${slot === "a" ? 1 : 2})` });
      const use = make("button", { type: "button", textContent: "View", disabled: true, title: `Go to snapshot ${slot.toUpperCase()} (${slot === "a" ? 1 : 2})` });
      keep.addEventListener("click", () => this.keep(slot));
      use.addEventListener("click", () => this.restore(slot));
      const row = make("div", { className: "slot" }, make("b", { textContent: slot.toUpperCase() }), keep, use);
      row.dataset.slot = slot;
      this.slots.append(row);
    }
  }

  /** @param {"a" | "b"} slot */
  keep(slot) {
    return this.session.ask("snapshot", { slot });
  }

  /** @param {"a" | "b"} slot */
  restore(slot) {
    if (this.session.state?.snapshots.includes(slot)) this.session.ask("restore", { slot });
  }

  /** Discards the rows and their thumbnails; called before another document is opened. */
  clear() {
    this.#rows.clear();
    this.#shown = "";
    this.#all = false;
    this.list.replaceChildren();
  }

  /** @param {State} state */
  show(state) {
    const { present } = state;
    for (const row of this.slots.children) {
      const slot = /** @type {"a" | "b"} */ (/** @type {HTMLElement} */ (row).dataset.slot);
      /** @type {HTMLButtonElement} */ (row.lastElementChild).disabled = !state.snapshots.includes(slot);
    }
    this.first.hidden = state.history.length < 2;
    const text = JSON.stringify([state.history, present]);
    if (text === this.#shown) return;
    this.#shown = text;
    const listed = this.#all ? state.history : state.history.filter(({ entry }, place) => place >= state.history.length - LISTED_COUNT || entry === present);
    this.earlier.hidden = listed.length === state.history.length;
    const entries = new Set(listed.map(({ entry }) => entry));
    for (const [entry, { item }] of this.#rows)
      if (!entries.has(entry)) {
        item.remove();
        this.#rows.delete(entry);
      }
    for (const { entry, label } of listed) {
      const row = this.#row(entry);
      if (row.label.textContent !== label) row.label.textContent = label;
      row.button.toggleAttribute("aria-current", entry === present);
    }
    const items = listed.map(({ entry }) => this.#row(entry).item);
    if (items.some((item, place) => this.list.children[place] !== item)) this.list.replaceChildren(...items);
    this.#rows.get(present)?.item.scrollIntoView({ block: "nearest" });
  }

  /** Returns the row of an entry. @param {number} entry */
  #row(entry) {
    const known = this.#rows.get(entry);
    if (known) return known;
    const picture = make("canvas", { width: THUMBNAIL_WIDTH, height: THUMBNAIL_HEIGHT });
    const label = make("span");
    const button = make("button", { type: "button" }, picture, label);
    button.addEventListener("click", () => this.session.ask("jump", { entry }));
    const row = { item: make("li", {}, button), button, picture, label };
    this.#rows.set(entry, row);
    return row;
  }

  /**
   * Draws the thumbnail of the current entry.
   * @param {State} state
   * @param {CanvasImageSource} picture
   * @param {[number, number]} size
   */
  draw(state, picture, [width, height]) {
    const canvas = this.#rows.get(state.present)?.picture;
    const scale = Math.max(THUMBNAIL_WIDTH / width, THUMBNAIL_HEIGHT / height);
    const [w, h] = [THUMBNAIL_WIDTH / scale, THUMBNAIL_HEIGHT / scale];
    canvas?.getContext("2d")?.drawImage(picture, (width - w) / 2, (height - h) / 2, w, h, 0, 0, THUMBNAIL_WIDTH, THUMBNAIL_HEIGHT);
  }
}
