// A canvas with a picture in a style, and the original left of a divider or while it is held.

import { Divider } from "./divider.js";
import { get, make, resize } from "./elements.js";

/** @typedef {import("./runner.js").LoadedStyle} LoadedStyle */
/** @typedef {{style: LoadedStyle, side: number}} Shown a style and the shorter side at which it is drawn */

/** Blur of the original until the first result, as part of the width. */
const WAITING_BLUR_RATIO = 0.006;

/** Returns the working size for a shorter side. @param {[number, number]} size @param {number} side @returns {[number, number]} */
export function workingSize([width, height], side) {
  const long = Math.max(side, Math.round((side * Math.max(width, height)) / Math.min(width, height)));
  return width < height ? [side, long] : [long, side];
}

/** Draws the present frame of a source; without a GPU in parts, so that the page stays responsive. */
export class StyledCanvas {
  canvas = /** @type {HTMLCanvasElement} */ (get("picture"));
  divider = new Divider(this.canvas, get("divider"), () => this.compose());
  /** @type {Shown | null} */
  shown = null;
  /** Whether the original is shown instead. */
  isHeld = false;
  /** The source in the style, as it came with the page; shown until it is drawn. @type {CanvasImageSource | null} */
  prepared = null;
  /** Whether the last frame is drawn. */
  isDrawn = false;
  /** Whether it has changed since the last frame began. */
  isOutdated = false;
  /** Is called with the time that a frame took, in milliseconds. @type {(milliseconds: number) => void} */
  ondrawn = () => {};
  /** Is called while a frame is drawn in parts, with the fraction that is drawn. @type {(part: number) => void} */
  onpart = () => {};
  /** Whether values have changed since the result. */
  #isExpired = false;
  #result = make("canvas");
  /** What the result is drawn with. @type {Shown | null} */
  #drawn = null;
  /** @type {Promise<void> | null} */
  #drawing = null;

  /** @param {import("./runner.js").Runner} runner @param {import("./source.js").Source} source */
  constructor(runner, source) {
    this.runner = runner;
    this.source = source;
    this.divider.listen();
  }

  /** Shows a new picture blurred, until it is drawn. */
  open() {
    this.isDrawn = false;
    this.prepared = null;
    this.compose();
  }

  /** Dims the result: values have changed. */
  expire() {
    this.#isExpired = true;
    this.compose();
  }

  /** Draws the present frame, after the one that is being drawn. */
  draw() {
    this.isOutdated = true;
    this.#drawing ??= this.#drawAll().finally(() => (this.#drawing = null));
    return this.#drawing;
  }

  /** Whether the result is complete and of the present values. */
  get isCurrent() {
    return this.isDrawn && !this.isOutdated && !this.#drawing && this.#drawn === this.shown;
  }

  /** The shorter side at which the result is drawn; 0: there is none. */
  get drawnSide() {
    return this.isDrawn ? (this.#drawn?.side ?? 0) : 0;
  }

  /** Returns the result of the present values, without the original, once it is drawn. */
  async finish() {
    await this.#drawing;
    if (!this.isCurrent) await this.draw();
    return this.#result;
  }

  async #drawAll() {
    while (this.isOutdated) {
      this.isOutdated = false;
      await this.#drawOnce();
    }
  }

  async #drawOnce() {
    const { runner, shown } = this;
    const { picture, size: own, time } = this.source;
    if (!picture || !own[0] || !shown) return this.compose();
    const began = performance.now();
    const size = workingSize(own, shown.side);
    const isOutdated = () => this.shown !== shown || this.source.picture !== picture;
    if (!(runner.isSoftware ? await runner.drawInParts(shown.style, picture, { time, size, isOutdated, onpart: this.onpart }) : runner.draw(shown.style, picture, undefined, { time, size }))) return;
    resize(this.#result, size);
    this.#result.getContext("2d")?.drawImage(runner.canvas, 0, 0, ...size, 0, 0, ...size);
    this.isDrawn = true;
    this.#isExpired &&= this.isOutdated;
    this.#drawn = shown;
    this.compose();
    this.ondrawn(performance.now() - began);
  }

  /** Shows the drawn picture, with the original in its part. */
  compose() {
    const { picture, size: own } = this.source;
    if (!picture || !own[0]) return;
    const size = this.isDrawn ? [this.#result.width, this.#result.height] : workingSize(own, this.shown?.side ?? Math.min(...own));
    resize(this.canvas, size);
    const styled = this.isDrawn ? this.#result : this.prepared;
    const isOriginal = this.isHeld || !styled;
    const context = /** @type {CanvasRenderingContext2D} */ (this.canvas.getContext("2d"));
    context.clearRect(0, 0, size[0], size[1]);
    // What waits for the style does not pass for its result.
    const waiting = styled ? `opacity(${this.#isExpired ? 0.5 : 1})` : `blur(${size[0] * WAITING_BLUR_RATIO}px) saturate(.3) opacity(.5)`;
    context.filter = this.isHeld ? "none" : waiting;
    context.drawImage(isOriginal ? picture : styled, 0, 0, size[0], size[1]);
    context.filter = "none";
    if (!isOriginal) this.divider.paint(picture, own);
    this.divider.place();
    this.divider.line.hidden ||= this.isHeld;
  }
}
