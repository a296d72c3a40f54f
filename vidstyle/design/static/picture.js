// The picture view: before and after, at the same zoom and position.

import { Divider } from "./divider.js";
import { oncePerFrame, resize } from "./elements.js";

/** @typedef {"result" | "split" | "side"} Mode */
/** @typedef {import("./divider.js").Box} Box */
/** @typedef {{picture: CanvasImageSource, size: [number, number]}} Shown */

const MIN_ZOOM = 0.05;
const MAX_ZOOM = 16;
/** Distance from the divider at which a pointer can drag it, in CSS pixels. */
const DIVIDER_GRIP_PX = 22;

/** Draws the source and the result on one canvas. */
export class PictureView {
  /** @type {Shown | null} */
  source = null;
  /** Until there is one, the source is shown. @type {Shown | null} */
  result = null;
  /** Takes the place of the source next to the result. @type {Shown | null} */
  opened = null;
  /** @type {Mode} */
  mode = "result";
  holding = false;
  /** Screen pixels per film pixel; null fits the picture to the window. @type {number | null} */
  zoom = null;
  /** The size of the film, to which 100 % refers. @type {[number, number]} */
  size = [1, 1];
  /** The point of the picture at the centre of the view, as fractions of its width and height. */
  center = { x: 0.5, y: 0.5 };
  /** Is called after the picture was drawn. */
  ondraw = () => {};
  /** @type {Map<number, PointerEvent>} */
  #pointers = new Map();
  #moves = "";
  /** The last position of the divider. */
  #split = 0.5;
  redraw = oncePerFrame(() => this.draw());

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {HTMLElement} line marks the divider
   * @param {() => void} onchange is called when the mode, zoom or position has changed
   */
  constructor(canvas, line, onchange) {
    this.canvas = canvas;
    this.onchange = onchange;
    this.divider = new Divider(canvas, line, () => this.#changed(), () => this.boxIn(this.panes[0]));
    new ResizeObserver(() => this.#changed()).observe(canvas);
    canvas.addEventListener("pointerdown", (event) => this.#down(event));
    canvas.addEventListener("pointermove", (event) => this.#move(event));
    for (const kind of ["pointerup", "pointercancel"])
      canvas.addEventListener(kind, (event) => this.#pointers.delete(/** @type {PointerEvent} */ (event).pointerId));
    canvas.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    canvas.addEventListener("dblclick", () => this.setZoom(this.zoom === null ? 1 : null));
  }

  /** @param {Mode} mode */
  setMode(mode) {
    this.mode = mode;
    this.#split = this.divider.split ?? this.#split;
    this.divider.move(mode === "split" ? this.#split : null);
  }

  /** @param {boolean} holding whether to show the source temporarily */
  hold(holding) {
    if (this.holding === holding) return;
    this.holding = holding;
    this.#changed();
  }

  /** @param {number | null} zoom @param {{x: number, y: number} | null} [at] a point of the picture that keeps its position */
  setZoom(zoom, at = null) {
    const before = this.scale;
    this.zoom = zoom === null ? null : Math.min(MAX_ZOOM, Math.max(MIN_ZOOM, zoom));
    if (this.zoom === null) this.center = { x: 0.5, y: 0.5 };
    else if (at) {
      const ratio = before / this.scale;
      this.center = { x: at.x + (this.center.x - at.x) * ratio, y: at.y + (this.center.y - at.y) * ratio };
    }
    this.#changed();
  }

  /** Pans the picture by CSS pixels. @param {number} x @param {number} y */
  pan(x, y) {
    this.center.x -= x / (this.size[0] * this.scale);
    this.center.y -= y / (this.size[1] * this.scale);
    this.center.x = Math.min(1, Math.max(0, this.center.x));
    this.center.y = Math.min(1, Math.max(0, this.center.y));
    this.#changed();
  }

  #changed() {
    this.onchange();
    this.redraw();
  }

  /** The panes, one for each picture, in CSS pixels: one, or two side by side or stacked. */
  get panes() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (this.mode !== "side") return [{ x: 0, y: 0, width, height }];
    const [wide, high] = this.size;
    const inRow = Math.min((width - 8) / 2 / wide, height / high);
    const inColumn = Math.min(width / wide, (height - 8) / 2 / high);
    const half = inRow >= inColumn ? { width: (width - 8) / 2, height } : { width, height: (height - 8) / 2 };
    const [x, y] = inRow >= inColumn ? [half.width + 8, 0] : [0, half.height + 8];
    return [{ x: 0, y: 0, ...half }, { x, y, ...half }];
  }

  /** CSS pixels per film pixel. */
  get scale() {
    const [pane] = this.panes;
    if (this.zoom !== null) return this.zoom / devicePixelRatio;
    return Math.min(pane.width / this.size[0], pane.height / this.size[1]);
  }

  /** Returns the rectangle of the whole picture for a pane. @param {Box} pane @returns {Box} */
  boxIn(pane) {
    const [width, height] = [this.size[0] * this.scale, this.size[1] * this.scale];
    const { x, y } = this.center;
    return { x: pane.x + pane.width / 2 - x * width, y: pane.y + pane.height / 2 - y * height, width, height };
  }

  draw() {
    this.#draw();
    this.ondraw();
  }

  #draw() {
    const { canvas } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((side) => Math.round(side * devicePixelRatio));
    resize(canvas, [width, height]);
    const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, width, height);
    context.scale(devicePixelRatio, devicePixelRatio);
    context.imageSmoothingQuality = "high";
    context.imageSmoothingEnabled = this.scale * devicePixelRatio < 3;
    const [first, second] = this.panes;
    const result = (!this.holding && this.result) || this.source;
    if (second) {
      this.#paint(context, this.opened ?? this.source, first, first);
      this.#paint(context, result, second, second);
      return;
    }
    this.#paint(context, result, first, first);
    if (this.mode !== "split" || this.holding) return;
    this.#paint(context, this.opened ?? this.source, first, { ...first, width: this.divider.at });
  }

  /** @param {CanvasRenderingContext2D} context @param {Shown | null} shown @param {Box} pane @param {Box} clip */
  #paint(context, shown, pane, clip) {
    if (!shown) return;
    const box = this.boxIn(pane);
    context.save();
    context.beginPath();
    context.rect(clip.x, clip.y, clip.width, clip.height);
    context.clip();
    context.drawImage(shown.picture, 0, 0, ...shown.size, box.x, box.y, box.width, box.height);
    context.restore();
  }

  /** Returns the point of the picture under the pointer, as fractions of its width and height. @param {MouseEvent} event */
  pointAt(event) {
    const { left, top } = this.canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - left, event.clientY - top];
    const pane = this.panes.find((each) => x < each.x + each.width && y < each.y + each.height) ?? this.panes[0];
    const box = this.boxIn(pane);
    return { x: (x - box.x) / box.width, y: (y - box.y) / box.height };
  }

  /** @param {PointerEvent} event */
  #down(event) {
    if (event.button) return;
    this.canvas.setPointerCapture(event.pointerId);
    this.#pointers.set(event.pointerId, event);
    const { left } = this.canvas.getBoundingClientRect();
    const near = Math.abs(event.clientX - left - this.divider.at) < DIVIDER_GRIP_PX;
    this.#moves = this.mode === "split" && (near || this.zoom === null) ? "divider" : "picture";
    if (this.#moves === "divider") this.divider.follow(event);
  }

  /** @param {PointerEvent} event */
  #move(event) {
    const before = this.#pointers.get(event.pointerId);
    if (!before) return;
    const other = [...this.#pointers.values()].find((each) => each.pointerId !== event.pointerId);
    if (other) {
      const [was, is] = [before, event].map((each) => Math.hypot(each.clientX - other.clientX, each.clientY - other.clientY));
      this.setZoom(this.scale * devicePixelRatio * (is / (was || 1)), this.pointAt(other));
    } else if (this.#moves === "divider") this.divider.follow(event);
    else if (this.zoom !== null) this.pan(event.clientX - before.clientX, event.clientY - before.clientY);
    this.#pointers.set(event.pointerId, event);
  }

  /** @param {WheelEvent} event */
  #wheel(event) {
    event.preventDefault();
    const factor = Math.exp(-event.deltaY * (event.ctrlKey ? 0.01 : 0.0015));
    this.setZoom(this.scale * devicePixelRatio * factor, this.pointAt(event));
  }
}
