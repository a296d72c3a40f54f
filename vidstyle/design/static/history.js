/**
 * The history of edits with small pictures, and two snapshots to compare.
 *
 * @module
 */

import { make } from "./elements.js";

/** @typedef {import("./types.js").State} State */

const WIDTH = 96;
const HEIGHT = 54;

/** Shows what was done, newest last. */
export class History {
  /** By the numbers of entries. @type {Map<number, HTMLCanvasElement>} */
  #pictures = new Map();
  #shown = "";

  /** @param {import("./session.js").Session} session */
  constructor(session) {
    this.session = session;
    this.list = make("ol", { className: "history" });
    this.slots = make("div", { className: "slots" });
    this.element = make("div", {}, make("h3", { textContent: "Snapshots" }), this.slots, make("h3", { textContent: "Edits" }), this.list);
    for (const slot of /** @type {("a" | "b")[]} */ (["a", "b"])) {
      const keep = make("button", { type: "button", textContent: "Keep", title: `Keep the present state as ${slot.toUpperCase()} (Shift+${slot === "a" ? 1 : 2})` });
      const use = make("button", { type: "button", textContent: "Show", disabled: true, title: `Go to snapshot ${slot.toUpperCase()} (${slot === "a" ? 1 : 2})` });
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

  /** Another document: the pictures are those of the one before. */
  clear() {
    this.#pictures.clear();
  }

  /** @param {State} state */
  show(state) {
    const { present } = state;
    for (const row of this.slots.children) {
      const slot = /** @type {"a" | "b"} */ (/** @type {HTMLElement} */ (row).dataset.slot);
      /** @type {HTMLButtonElement} */ (row.lastElementChild).disabled = !state.snapshots.includes(slot);
    }
    const text = JSON.stringify([state.history, present]);
    if (text === this.#shown) return;
    this.#shown = text;
    const rows = state.history.map(({ entry, label }) => {
      const picture = this.#pictures.get(entry) ?? make("canvas", { width: WIDTH, height: HEIGHT });
      this.#pictures.set(entry, picture);
      const button = make("button", { type: "button" }, picture, make("span", { textContent: label }));
      button.toggleAttribute("aria-current", entry === present);
      button.addEventListener("click", () => this.session.ask("jump", { entry }));
      return make("li", {}, button);
    });
    this.list.replaceChildren(...rows);
    this.list.querySelector("[aria-current]")?.scrollIntoView({ block: "nearest" });
  }

  /**
   * Draws the picture of the present entry.
   * @param {State} state
   * @param {CanvasImageSource} picture
   * @param {[number, number]} size
   */
  draw(state, picture, [width, height]) {
    const canvas = this.#pictures.get(state.present);
    const scale = Math.max(WIDTH / width, HEIGHT / height);
    const [w, h] = [WIDTH / scale, HEIGHT / scale];
    canvas?.getContext("2d")?.drawImage(picture, (width - w) / 2, (height - h) / 2, w, h, 0, 0, WIDTH, HEIGHT);
  }
}
