// The strips of kept looks and of earlier screens.

import { get, make } from "./elements.js";
import { nameOf } from "./tile_names.js";

/** @typedef {import("./explore_types.js").State} State */
/** @typedef {import("./explore_types.js").Tile} Tile */

/** The width of a thumbnail in pixels of the screen, at most. */
const MAX_THUMBNAIL_WIDTH_PX = 240;

/** Shows them as thumbnails. */
export class Strips {
  /** The addresses of the final pictures of tiles, by their number. @type {Map<number, string>} */
  #finals = new Map();

  /**
   * @param {(screen: number) => void} onjump
   * @param {(tile: Tile) => void} onopen
   */
  constructor(onjump, onopen) {
    this.onjump = onjump;
    this.onopen = onopen;
  }

  /** Returns a thumbnail of a tile: its final picture, until that is drawn a draft. @param {number} tile */
  #thumbnail(tile) {
    const shown = make("img", { src: this.#finals.get(tile) ?? `look.jpg?tile=${tile}`, alt: "", draggable: false });
    shown.dataset.tile = String(tile);
    return shown;
  }

  /** Lets the thumbnails of a tile show what its canvas shows: its final picture. @param {number} tile @param {HTMLCanvasElement} canvas */
  keepFinal(tile, canvas) {
    if (this.#finals.has(tile)) return;
    const width = Math.min(MAX_THUMBNAIL_WIDTH_PX, canvas.width);
    const small = make("canvas", { width, height: Math.round((width * canvas.height) / canvas.width) });
    const context = /** @type {CanvasRenderingContext2D} */ (small.getContext("2d"));
    context.imageSmoothingQuality = "high";
    context.drawImage(canvas, 0, 0, small.width, small.height);
    this.#finals.set(tile, `look.jpg?tile=${tile}`); // until it is encoded, outside of the page's heap
    small.toBlob((blob) => blob && this.#replace(tile, URL.createObjectURL(blob)), "image/jpeg");
  }

  /** @param {number} tile @param {string} address of its thumbnail */
  #replace(tile, address) {
    this.#finals.set(tile, address);
    for (const shown of /** @type {NodeListOf<HTMLImageElement>} */ (document.querySelectorAll(`img[data-tile="${tile}"]`))) shown.src = address;
  }

  /** Adds the new screens, and marks the present one. @param {State} state */
  showHistory({ history, at }) {
    const strip = get("seen");
    for (const [number, shown] of history.entries()) {
      const button = /** @type {HTMLElement | undefined} */ (strip.children[number]) ?? this.#screen(number, shown);
      if (!button.isConnected) strip.append(button);
      button.setAttribute("aria-current", String(number === at));
      if (number === at) this.#reveal(button);
    }
  }

  /** Scrolls the rail to a screen. On a narrow page the rail cannot scroll, and the page must stay where it is. @param {HTMLElement} button */
  #reveal(button) {
    const rail = get("rail");
    const [shown, { top, bottom }] = [button.getBoundingClientRect(), rail.getBoundingClientRect()];
    rail.scrollTop += Math.max(0, shown.bottom - bottom) + Math.min(0, shown.top - top);
  }

  /** Returns the button that shows a screen again. @param {number} number @param {number[]} shown the tiles that stand for it */
  #screen(number, shown) {
    const name = `Screen ${number + 1}`;
    const button = make("button", { className: shown.length > 1 ? "four" : "", title: name, onclick: () => this.onjump(number) }, ...shown.map((tile) => this.#thumbnail(tile)));
    button.setAttribute("aria-label", name);
    return button;
  }

  /** @param {Tile[]} kept */
  showKept(kept) {
    get("none").hidden = kept.length > 0;
    const buttons = kept.map((tile) => {
      const button = make("button", { title: `Open: ${nameOf(tile)}`, onclick: () => this.onopen(tile) }, this.#thumbnail(tile.tile), make("span", { textContent: nameOf(tile) }));
      button.setAttribute("aria-label", `Kept: ${nameOf(tile)}`);
      return button;
    });
    get("kept").replaceChildren(...buttons);
  }
}
