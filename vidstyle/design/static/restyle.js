// Renders the style in the browser: runs the plans from the server with `runner.js`.

import { Runner, missing } from "./runner.js";

/** @typedef {import("./runner.js").Source} Source */
/** @typedef {{for: "main" | "solo", revision: number, key: string, values: number[], plan?: import("./runner.js").Plan}} PlanMessage */

/** Renders the style and the output of the soloed step. */
export class Restyler {
  /** @type {Runner | null} */
  runner = null;
  /** Why this browser cannot render; "" if it can. */
  reason = "";
  /** Loaded plans by key; the server sends each plan once. @type {Map<string, Promise<import("./runner.js").LoadedStyle>>} */
  #loaded = new Map();
  /** @type {Map<string, import("./runner.js").LoadedStyle>} */
  #current = new Map();
  /** The revision of the document that each purpose shows. @type {Map<string, number>} */
  revisions = new Map();
  /** The key of the newest plan for each purpose; it may still be compiling. @type {Map<string, string>} */
  #wanted = new Map();

  /**
   * @param {() => void} onchange is called when the picture must be drawn again
   * @param {(text: string) => void} onerror
   */
  constructor(onchange, onerror) {
    this.onchange = onchange;
    this.onerror = onerror;
    const lacks = missing();
    this.reason = lacks[0] ?? "";
    if (!this.reason) this.runner = new Runner({ onrestored: onchange });
  }

  /** Whether the browser renders on a GPU. */
  get isFast() {
    return this.runner !== null && !this.runner.isSoftware;
  }

  /** @param {PlanMessage} message */
  async take({ for: purpose, revision, key, values, plan }) {
    if (!this.runner) return;
    this.#wanted.set(purpose, key);
    if (plan) this.#loaded.set(key, this.runner.load(plan));
    try {
      const style = await this.#loaded.get(key);
      if (!style || this.#wanted.get(purpose) !== key) return;
      const before = this.#current.get(purpose);
      this.#current.set(purpose, style);
      style.values = values;
      this.revisions.set(purpose, revision);
      if (before !== style) style.restart();
      if (before && ![...this.#current.values()].includes(before)) before.release();
      this.onchange();
    } catch (error) {
      this.onerror(/** @type {Error} */ (error).message);
    }
  }

  /**
   * Restyles a picture.
   * @param {"main" | "solo"} purpose
   * @param {Source} source
   * @param {number | null} time in seconds; null: a still picture
   * @param {HTMLCanvasElement} canvas the target
   * @returns {boolean} whether it was drawn
   */
  draw(purpose, source, time, canvas) {
    const style = this.#current.get(purpose);
    if (!this.runner || !style) return false;
    try {
      return this.runner.draw(style, source, canvas, { time }) !== null;
    } catch (error) {
      this.onerror(/** @type {Error} */ (error).message);
      return false;
    }
  }

  /** Releases the styles: another document follows. */
  forget() {
    for (const style of this.#current.values()) style.release();
    this.#current.clear();
  }

  /** Resets the measurements: a new film or scene begins. */
  restart() {
    for (const style of this.#current.values()) style.restart();
  }
}
