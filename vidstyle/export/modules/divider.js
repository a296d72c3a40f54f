// The divider between before and after, over a picture.

import { followPointer } from "./elements.js";

/** @typedef {{x: number, y: number, width: number, height: number}} Box in CSS pixels, within the parent of the canvas */

/** Returns the box of a picture that is shown whole in its canvas. @param {HTMLCanvasElement} canvas @returns {Box} */
export function boxOf(canvas) {
  const { offsetLeft, offsetTop, offsetWidth, offsetHeight } = canvas;
  const scale = Math.min(offsetWidth / canvas.width, offsetHeight / canvas.height);
  const [width, height] = [canvas.width * scale, canvas.height * scale];
  return { x: offsetLeft + (offsetWidth - width) / 2, y: offsetTop + (offsetHeight - height) / 2, width, height };
}

/** Divides a picture into a part before, on the left, and a part after. */
export class Divider {
  /** The fraction of the width that shows the picture before; null: no divider. @type {number | null} */
  split = null;

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {HTMLElement} line marks the divider; it has the same parent as the canvas
   * @param {() => void} onchange is called when the divider has moved
   * @param {() => Box} box returns the box of the picture
   */
  constructor(canvas, line, onchange, box = () => boxOf(canvas)) {
    this.canvas = canvas;
    this.line = line;
    this.onchange = onchange;
    this.box = box;
    const follower = new ResizeObserver(() => this.place());
    for (const element of [canvas, this.#parent]) follower.observe(element);
  }

  /** Lets the pointer drag the divider from anywhere on the canvas. */
  listen() {
    followPointer(this.canvas, (event) => this.follow(event), (event) => this.split !== null && !event.button);
  }

  /** Moves the divider. @param {number | null} split null: hide it */
  move(split) {
    this.split = split === null ? null : Math.min(1, Math.max(0, split));
    this.place();
    this.onchange();
  }

  toggle() {
    this.move(this.split === null ? 0.5 : null);
  }

  /** Moves the divider to a pointer. @param {MouseEvent} event */
  follow(event) {
    const { x, width } = this.box();
    const left = this.#parent.getBoundingClientRect().left;
    this.move((event.clientX - left - x) / width);
  }

  /** The distance from the left edge of the parent to the divider, in CSS pixels. */
  get at() {
    const { x, width } = this.box();
    return Math.min(this.#parent.clientWidth, Math.max(0, x + (this.split ?? 0) * width));
  }

  /** Positions the line; `--picture-top` and `--picture-right` position what else belongs to the picture. */
  place() {
    const { x, y, width, height } = this.box();
    this.#parent.style.setProperty("--picture-top", `${Math.max(0, y)}px`);
    this.#parent.style.setProperty("--picture-right", `${x + width}px`);
    this.line.hidden = this.split === null;
    if (this.line.hidden) return;
    const [begin, end] = [Math.max(0, y), Math.min(this.#parent.clientHeight, y + height)];
    Object.assign(this.line.style, { left: `${this.at}px`, top: `${begin}px`, height: `${end - begin}px` });
  }

  /** Draws the part before onto the canvas. @param {CanvasImageSource} picture @param {[number, number]} size of the picture */
  paint(picture, [width, height]) {
    const part = Math.round((this.split ?? 0) * this.canvas.width);
    if (!part) return;
    const context = this.canvas.getContext("2d");
    context?.drawImage(picture, 0, 0, (part / this.canvas.width) * width, height, 0, 0, part, this.canvas.height);
  }

  get #parent() {
    return /** @type {HTMLElement} */ (this.canvas.parentElement);
  }
}
