// The splitter between picture and diagram.

import { followPointer, get } from "./elements.js";

const MIN_HEIGHT_PX = 120;
const KEY_STEP_PX = 24;
/** The largest share of the height that the diagram takes by default. */
const MAX_DEFAULT_SHARE = 0.55;

/** Sets the height of the diagram: to fit its content, or as the user drags it. */
export class Splitter {
  /** The height that the user has set, in CSS pixels. @type {number | null} */
  #chosen = null;

  /** @param {() => void} onchange */
  constructor(onchange) {
    this.onchange = onchange;
    this.bar = get("splitter");
    followPointer(this.bar, (event) => event.type === "pointermove" && this.#set(get("diagram").getBoundingClientRect().bottom - event.clientY));
    this.bar.addEventListener("dblclick", () => this.#set(null));
    this.bar.addEventListener("keydown", (event) => {
      const steps = { ArrowUp: 1, ArrowDown: -1 }[event.key];
      if (steps) this.#set(get("diagram").clientHeight + steps * KEY_STEP_PX);
    });
  }

  /** Announces the height as a percentage of the space. */
  describe() {
    const space = Math.max(1, get("work").clientHeight);
    this.bar.setAttribute("aria-valuenow", String(Math.round((100 * get("diagram").clientHeight) / space)));
  }

  /** The maximum height of the diagram, in CSS pixels. */
  get maxHeight() {
    return this.#chosen ?? Math.round(MAX_DEFAULT_SHARE * get("work").clientHeight);
  }

  /** @param {number | null} height null: fit the content */
  #set(height) {
    const most = Math.max(MIN_HEIGHT_PX, get("work").clientHeight - 2 * MIN_HEIGHT_PX);
    this.#chosen = height === null ? null : Math.round(Math.min(most, Math.max(MIN_HEIGHT_PX, height)));
    document.documentElement.style.setProperty("--diagram", this.#chosen === null ? "" : `${this.#chosen}px`);
    this.describe();
    this.onchange();
  }
}
