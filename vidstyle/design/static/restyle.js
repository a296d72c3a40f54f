/**
 * Runs the style in the browser: the plans that the server sends, drawn by `runner.js`.
 *
 * @module
 */

import { Runner, missing } from "./runner.js";

/** @typedef {import("./runner.js").Source} Source */
/** @typedef {{for: "main" | "solo", key: string, values: number[], plan?: import("./runner.js").Plan}} PlanMessage */

/** The style and, beside it, what leaves a single step. */
export class Restyler {
  /** @type {Runner | null} */
  runner = null;
  /** What keeps this browser from it; "" for nothing. */
  reason = "";
  /** By their keys; the server sends each plan once. @type {Map<string, Promise<import("./runner.js").LoadedStyle>>} */
  #loaded = new Map();
  /** @type {Map<string, import("./runner.js").LoadedStyle>} */
  #current = new Map();
  /** The newest plan of each purpose, which may still be compiled. @type {Map<string, string>} */
  #wanted = new Map();

  /**
   * @param {() => void} onchange is called when the next picture will be another
   * @param {(text: string) => void} onerror
   */
  constructor(onchange, onerror) {
    this.onchange = onchange;
    this.onerror = onerror;
    const lacks = missing();
    this.reason = lacks[0] ?? "";
    if (!this.reason) this.runner = new Runner({ onrestored: onchange });
  }

  /** Whether the browser has a graphics card of its own for it. */
  get isFast() {
    return this.runner !== null && !this.runner.isSoftware;
  }

  /** @param {PlanMessage} message */
  async take({ for: purpose, key, values, plan }) {
    if (!this.runner) return;
    this.#wanted.set(purpose, key);
    if (plan) this.#loaded.set(key, this.runner.load(plan));
    try {
      const style = await this.#loaded.get(key);
      if (!style || this.#wanted.get(purpose) !== key) return;
      const before = this.#current.get(purpose);
      this.#current.set(purpose, style);
      style.values = values;
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
   * @param {number | null} time in seconds; null: the picture stands alone
   * @param {HTMLCanvasElement} canvas where to
   * @returns {boolean} whether there is a result
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

  /** Another film or scene begins. */
  restart() {
    for (const style of this.#current.values()) style.restart();
  }
}
