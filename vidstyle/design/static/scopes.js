// Scopes for the picture: histogram and waveform of the result, and a loupe with the values under the pointer.

import { get, make, oncePerFrame, press } from "./elements.js";

/** @typedef {import("./picture.js").PictureView} PictureView */
/** @typedef {import("./picture.js").Shown} Shown */

const SAMPLED_WIDTH = 256;
const SCOPE_HEIGHT = 96;
/** Rows and columns of pixels that the loupe shows. */
const LOUPE_SIDE = 9;
/** Weights of red, green and blue in luma (BT.709). */
const LUMA = [0.2126, 0.7152, 0.0722];
const COLORS = ["#f05050", "#40c060", "#5080ff"];

/** Shows the scopes while they are open. */
export class Scopes {
  #sampler = make("canvas");
  #histogram = scope("Histogram of the result: dark tones left, bright tones right");
  #waveform = scope("Waveform of the result: luma of each column, bright tones at the top");
  #before = scope("Pixels of the original under the pointer");
  #after = scope("Pixels of the result under the pointer");
  #values = make("p", { textContent: "Move the pointer over the picture for its values." });

  /** @param {PictureView} view */
  constructor(view) {
    this.view = view;
    this.panel = get("scopes");
    for (const loupe of [this.#before, this.#after]) [loupe.width, loupe.height] = [LOUPE_SIDE, LOUPE_SIDE];
    const loupes = make("div", { className: "loupes" }, this.#before, this.#after);
    this.panel.append(this.#histogram, this.#waveform, loupes, this.#values);
    view.ondraw = oncePerFrame(() => this.#draw());
    view.canvas.addEventListener("pointermove", (event) => this.#look(event));
    get("to-scopes").addEventListener("click", () => this.toggle());
  }

  toggle() {
    this.panel.hidden = !this.panel.hidden;
    press(get("to-scopes"), !this.panel.hidden);
    this.#draw();
  }

  #draw() {
    const { result, source } = this.view;
    const shown = this.view.holding ? source : result;
    if (this.panel.hidden || !shown) return;
    const height = Math.max(1, Math.round((SAMPLED_WIDTH * shown.size[1]) / shown.size[0]));
    const pixels = this.#sample(shown, 0, 0, ...shown.size, SAMPLED_WIDTH, height);
    this.#drawHistogram(pixels);
    this.#drawWaveform(pixels);
  }

  /**
   * Returns the RGBA values of a part of a picture.
   * @param {Shown} shown
   * @param {number} x @param {number} y @param {number} w @param {number} h the part
   * @param {number} width @param {number} height the size of the result
   */
  #sample({ picture }, x, y, w, h, width, height) {
    [this.#sampler.width, this.#sampler.height] = [width, height];
    const context = /** @type {CanvasRenderingContext2D} */ (this.#sampler.getContext("2d", { willReadFrequently: true }));
    context.imageSmoothingEnabled = false;
    context.drawImage(picture, x, y, w, h, 0, 0, width, height);
    return context.getImageData(0, 0, width, height).data;
  }

  /** @param {Uint8ClampedArray} pixels */
  #drawHistogram(pixels) {
    const counts = COLORS.map(() => new Float32Array(256));
    for (let at = 0; at < pixels.length; at += 4) for (let part = 0; part < 3; part++) counts[part][pixels[at + part]] += 1;
    // Pure black and white may hold most pixels, and would flatten everything else.
    const most = Math.max(1, ...counts.map((each) => Math.max(...each.subarray(1, 255))));
    const context = clear(this.#histogram);
    context.globalCompositeOperation = "lighter";
    for (const [part, color] of COLORS.entries()) {
      context.fillStyle = color;
      counts[part].forEach((count, tone) => {
        const height = Math.min(1, count / most) * SCOPE_HEIGHT;
        context.fillRect(tone, SCOPE_HEIGHT - height, 1, height);
      });
    }
  }

  /** @param {Uint8ClampedArray} pixels */
  #drawWaveform(pixels) {
    const context = clear(this.#waveform);
    context.fillStyle = "#ffffff18";
    for (let at = 0; at < pixels.length; at += 4) {
      const luma = LUMA[0] * pixels[at] + LUMA[1] * pixels[at + 1] + LUMA[2] * pixels[at + 2];
      context.fillRect((at / 4) % SAMPLED_WIDTH, Math.round((1 - luma / 255) * (SCOPE_HEIGHT - 1)), 1, 1);
    }
  }

  /** Shows the pixels and values under the pointer. @param {PointerEvent} event */
  #look(event) {
    const { source, result } = this.view;
    if (this.panel.hidden || !source || !result) return;
    const { x, y } = this.view.pointAt(event);
    if (x < 0 || y < 0 || x >= 1 || y >= 1) return;
    const texts = [[source, this.#before], [result, this.#after]].map(([shown, loupe]) => this.#magnify(/** @type {Shown} */ (shown), /** @type {HTMLCanvasElement} */ (loupe), x, y));
    const [wide, high] = this.view.size;
    this.#values.textContent = `x ${Math.floor(x * wide)}, y ${Math.floor(y * high)}: ${texts.join(" → ")}`;
  }

  /** Draws the pixels round a point; returns its red, green and blue. @param {Shown} shown @param {HTMLCanvasElement} loupe @param {number} x @param {number} y */
  #magnify(shown, loupe, x, y) {
    const half = (LOUPE_SIDE - 1) / 2;
    const [left, top] = [Math.floor(x * shown.size[0]) - half, Math.floor(y * shown.size[1]) - half];
    const pixels = this.#sample(shown, left, top, LOUPE_SIDE, LOUPE_SIDE, LOUPE_SIDE, LOUPE_SIDE);
    loupe.getContext("2d")?.putImageData(new ImageData(new Uint8ClampedArray(pixels), LOUPE_SIDE, LOUPE_SIDE), 0, 0);
    const middle = 4 * (half * LOUPE_SIDE + half);
    return [...pixels.slice(middle, middle + 3)].join(" ");
  }
}

/** @param {string} label */
function scope(label) {
  const canvas = make("canvas", { width: SAMPLED_WIDTH, height: SCOPE_HEIGHT });
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", label);
  return canvas;
}

/** @param {HTMLCanvasElement} canvas */
function clear(canvas) {
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  context.globalCompositeOperation = "source-over";
  context.clearRect(0, 0, canvas.width, canvas.height);
  return context;
}
