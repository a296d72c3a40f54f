/**
 * The bar between picture and diagram.
 *
 * @module
 */

import { get } from "./elements.js";

const LEAST = 120;
const STEP = 24;
/** The part of the height that the diagram takes at most, unless the user makes it higher. */
const MOST = 0.53;

/** Sets the height of the diagram: by its content, or as the user drags it. */
export class Splitter {
  /** What the user has chosen, in CSS pixels. @type {number | null} */
  #chosen = null;

  /** @param {() => void} onchange */
  constructor(onchange) {
    this.onchange = onchange;
    this.bar = get("splitter");
    this.bar.addEventListener("pointerdown", (event) => this.bar.setPointerCapture(event.pointerId));
    this.bar.addEventListener("pointermove", (event) => {
      if (this.bar.hasPointerCapture(event.pointerId)) this.#set(get("diagram").getBoundingClientRect().bottom - event.clientY);
    });
    this.bar.addEventListener("dblclick", () => this.#set(null));
    this.bar.addEventListener("keydown", (event) => {
      const steps = { ArrowUp: 1, ArrowDown: -1 }[event.key];
      if (steps) this.#set(get("diagram").clientHeight + steps * STEP);
    });
  }

  /** The height that the diagram may take, in CSS pixels. */
  get room() {
    return this.#chosen ?? Math.round(MOST * get("work").clientHeight);
  }

  /** @param {number | null} height null: by the content */
  #set(height) {
    const most = Math.max(LEAST, get("work").clientHeight - 2 * LEAST);
    this.#chosen = height === null ? null : Math.round(Math.min(most, Math.max(LEAST, height)));
    document.documentElement.style.setProperty("--diagram", this.#chosen === null ? "" : `${this.#chosen}px`);
    this.bar.setAttribute("aria-valuenow", String(this.room));
    this.onchange();
  }
}
