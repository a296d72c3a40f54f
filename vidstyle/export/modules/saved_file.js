// Saving the picture of a page.

import { download, get } from "./elements.js";

/** Returns the file name of a result: the name of its source, if it has one, and the name of its style. @param {string} source @param {string} look @param {string} extension */
export const nameOfResult = (source, look, extension) => `${source ? `${source}-` : ""}${look}.${extension}`;

/**
 * Returns a picture as PNG, reduced to the size of its source: marks are drawn finer than a small source.
 * @param {HTMLCanvasElement} canvas
 * @param {[number, number]} own the size of the source
 * @returns {Promise<{blob: Blob | null, size: [number, number]}>}
 */
async function pngOf(canvas, own) {
  const isLarger = canvas.width > own[0];
  const saved = isLarger ? document.createElement("canvas") : canvas;
  if (isLarger) {
    [saved.width, saved.height] = own;
    const context = /** @type {CanvasRenderingContext2D} */ (saved.getContext("2d"));
    context.imageSmoothingQuality = "high";
    context.drawImage(canvas, 0, 0, ...own);
  }
  return { blob: await new Promise((done) => saved.toBlob(done)), size: [saved.width, saved.height] };
}

/** Saves pictures; its button shows the progress. */
export class PictureSaver {
  /** The fraction of the picture that is drawn; null: no picture is being saved. @type {number | null} */
  #part = null;

  /** @param {() => Promise<HTMLCanvasElement>} finish draws the picture in full resolution @param {(text: string) => void} say */
  constructor(finish, say) {
    this.finish = finish;
    this.say = say;
  }

  /** Saves the picture once it is drawn. @param {import("./source.js").Source} source @param {string} look */
  async save(source, look) {
    if (this.#part !== null) return;
    this.#mark(0);
    try {
      const canvas = await this.finish();
      const own = source.size;
      const { blob, size } = await pngOf(canvas, own);
      const name = nameOfResult(source.name, look, "png");
      if (blob) download(blob, name);
      const larger = size[0] < own[0] ? ` “vidstyle render” draws all ${own.join(" × ")}.` : "";
      this.say(blob ? `${name} is in your downloads: ${size.join(" × ")} pixels.${larger}` : "The picture cannot be saved.");
    } finally {
      this.#mark(null);
    }
  }

  /** Shows how much of a picture that is being saved is drawn. @param {number} part */
  progress(part) {
    if (this.#part !== null) this.#mark(Math.max(this.#part, part));
  }

  /** @param {number | null} part */
  #mark(part) {
    this.#part = part;
    get("save").ariaBusy = String(part !== null);
    get("save-label").textContent = part === null ? "Save picture" : part ? `Saving… ${Math.round(100 * part)}\u00a0%` : "Saving…";
  }
}
