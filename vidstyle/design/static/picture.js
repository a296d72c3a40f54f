/**
 * The picture: before and after, at one zoom.
 *
 * @module
 */

/** @typedef {"result" | "split" | "side"} Mode */
/** @typedef {{x: number, y: number, width: number, height: number}} Box */
/** @typedef {{picture: CanvasImageSource, size: [number, number]}} Shown */

const LEAST = 0.05;
const MOST = 16;
/** How far from the divider a pointer takes hold of it, in CSS pixels. */
const GRIP = 22;

/** Draws source and result into one canvas. */
export class PictureView {
  /** @type {Shown | null} */
  source = null;
  /** @type {Shown | null} */
  result = null;
  /** @type {Mode} */
  mode = "result";
  holding = false;
  split = 0.5;
  /** Pixels of the screen for one of the film; null fits the picture into the window. @type {number | null} */
  zoom = null;
  /** The size of the film: what 100 % means. @type {[number, number]} */
  size = [1, 1];
  /** The point of the picture in the middle, as parts of its sides. */
  center = { x: 0.5, y: 0.5 };
  /** @type {Map<number, PointerEvent>} */
  #pointers = new Map();
  #moves = "";
  #pending = false;

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {() => void} onchange is called when mode, zoom or place have changed
   */
  constructor(canvas, onchange) {
    this.canvas = canvas;
    this.onchange = onchange;
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
    this.#changed();
  }

  /** @param {boolean} holding whether the source is shown for now */
  hold(holding) {
    if (this.holding === holding) return;
    this.holding = holding;
    this.#changed();
  }

  /** @param {number | null} zoom @param {{x: number, y: number} | null} [at] a point of the picture that stays */
  setZoom(zoom, at = null) {
    const before = this.scale;
    this.zoom = zoom === null ? null : Math.min(MOST, Math.max(LEAST, zoom));
    if (this.zoom === null) this.center = { x: 0.5, y: 0.5 };
    else if (at) {
      const ratio = before / this.scale;
      this.center = { x: at.x + (this.center.x - at.x) * ratio, y: at.y + (this.center.y - at.y) * ratio };
    }
    this.#changed();
  }

  /** Moves the picture by CSS pixels. @param {number} x @param {number} y */
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

  redraw() {
    if (this.#pending) return;
    this.#pending = true;
    requestAnimationFrame(() => {
      this.#pending = false;
      this.draw();
    });
  }

  /** The parts of the window for a picture each, in CSS pixels: one, or two side by side or one above the other. */
  get panes() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (this.mode !== "side") return [{ x: 0, y: 0, width, height }];
    const [wide, high] = this.size;
    const beside = Math.min((width - 8) / 2 / wide, height / high);
    const above = Math.min(width / wide, (height - 8) / 2 / high);
    const half = beside >= above ? { width: (width - 8) / 2, height } : { width, height: (height - 8) / 2 };
    const [x, y] = beside >= above ? [half.width + 8, 0] : [0, half.height + 8];
    return [{ x: 0, y: 0, ...half }, { x, y, ...half }];
  }

  /** CSS pixels for one pixel of the film. */
  get scale() {
    const [pane] = this.panes;
    if (this.zoom !== null) return this.zoom / devicePixelRatio;
    return Math.min(pane.width / this.size[0], pane.height / this.size[1]);
  }

  /** Where the whole picture lies for a pane. @param {Box} pane @returns {Box} */
  boxIn(pane) {
    const [width, height] = [this.size[0] * this.scale, this.size[1] * this.scale];
    const { x, y } = this.center;
    return { x: pane.x + pane.width / 2 - x * width, y: pane.y + pane.height / 2 - y * height, width, height };
  }

  draw() {
    const { canvas } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((side) => Math.round(side * devicePixelRatio));
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, width, height);
    context.scale(devicePixelRatio, devicePixelRatio);
    context.imageSmoothingQuality = "high";
    context.imageSmoothingEnabled = this.scale * devicePixelRatio < 3;
    const [first, second] = this.panes;
    if (second) {
      this.#paint(context, this.source, first, first);
      this.#paint(context, this.holding ? this.source : this.result, second, second);
      return;
    }
    this.#paint(context, this.holding ? this.source : this.result, first, first);
    if (this.mode !== "split" || this.holding) return;
    const at = this.dividerAt(first);
    this.#paint(context, this.source, first, { ...first, width: at - first.x });
    context.fillStyle = "#ffffffd0";
    context.fillRect(at - 0.75, first.y, 1.5, first.height);
  }

  /** Where the divider stands, in CSS pixels. @param {Box} [pane] */
  dividerAt(pane = this.panes[0]) {
    const box = this.boxIn(pane);
    const [left, right] = [Math.max(pane.x, box.x), Math.min(pane.x + pane.width, box.x + box.width)];
    return Math.min(right, Math.max(left, box.x + this.split * box.width));
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

  /** The point of the picture below the pointer, as parts of its sides. @param {MouseEvent} event */
  #pointAt(event) {
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
    const near = Math.abs(event.clientX - left - this.dividerAt()) < GRIP;
    this.#moves = this.mode === "split" && (near || this.zoom === null) ? "divider" : "picture";
    if (this.#moves === "divider") this.#divide(event);
  }

  /** @param {PointerEvent} event */
  #divide(event) {
    this.split = Math.min(1, Math.max(0, this.#pointAt(event).x));
    this.#changed();
  }

  /** @param {PointerEvent} event */
  #move(event) {
    const before = this.#pointers.get(event.pointerId);
    if (!before) return;
    const other = [...this.#pointers.values()].find((each) => each.pointerId !== event.pointerId);
    if (other) {
      const [was, is] = [before, event].map((each) => Math.hypot(each.clientX - other.clientX, each.clientY - other.clientY));
      this.setZoom(this.scale * devicePixelRatio * (is / (was || 1)), this.#pointAt(other));
    } else if (this.#moves === "divider") this.#divide(event);
    else if (this.zoom !== null) this.pan(event.clientX - before.clientX, event.clientY - before.clientY);
    this.#pointers.set(event.pointerId, event);
  }

  /** @param {WheelEvent} event */
  #wheel(event) {
    event.preventDefault();
    const factor = Math.exp(-event.deltaY * (event.ctrlKey ? 0.01 : 0.0015));
    this.setZoom(this.scale * devicePixelRatio * factor, this.#pointAt(event));
  }
}
