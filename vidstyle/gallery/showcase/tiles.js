// Small pictures of all styles, drawn one after another with one WebGL context.

import { get, make, resize } from "./elements.js";
import { loadStyleData } from "./store.js";
import { workingSize } from "./styled_canvas.js";
import { loadStyle } from "./viewer.js";

/** @typedef {{name: string, note: string}} Listed */

/** A style in the list, with its picture. */
class Tile {
  isVisible = false;
  /** Whether its picture is older than that of the source. */
  isStale = false;
  /** @type {(import("./plan_values.js").SizedPlan & {style: import("./runner.js").LoadedStyle}) | null} */
  #loaded = null;

  /** @param {Listed} style */
  constructor({ name, note }) {
    this.name = name;
    this.canvas = make("canvas");
    this.canvas.setAttribute("aria-hidden", "true");
    this.image = make("img", { alt: "", loading: "lazy", decoding: "async" });
    this.link = make("a", { href: `#${encodeURIComponent(name)}`, className: "tile" });
    this.link.append(this.image, this.canvas, make("h3", { textContent: name }), make("p", { textContent: note }));
    this.canvas.hidden = true;
  }

  /** Shows a finished picture. @param {string} src */
  showImage(src) {
    this.image.src = src;
    this.image.hidden = false;
    this.canvas.hidden = true;
    this.isStale = false;
  }

  /** Draws the picture of a source. @param {import("./runner.js").Runner} runner @param {import("./source.js").Source} source */
  async draw(runner, source) {
    const data = await loadStyleData(this.name);
    const { style, side } = (this.#loaded ??= await loadStyle(runner, data.plans[0]));
    if (!source.picture || !source.size[0]) return;
    const size = workingSize(source.size, side);
    resize(this.canvas, size);
    runner.draw(style, source.picture, this.canvas, { time: source.time, size });
    if (!source.video) style.release();
    this.canvas.hidden = false;
    this.image.hidden = true;
  }
}

/** The list of tiles in the element `tiles`. Visible ones are drawn first; films and cameras move. */
export class Tiles {
  /** @type {Tile[]} */
  tiles = [];
  /** Drawing pauses, for example while the large picture is open. */
  isPaused = false;
  #isDrawing = false;

  /**
   * @param {Listed[]} styles
   * @param {import("./source.js").Source} source
   * @param {(done: number, count: number) => void} onprogress is called after each picture of a photograph
   */
  constructor(styles, source, onprogress) {
    this.source = source;
    this.onprogress = onprogress;
    /** @type {import("./runner.js").Runner | null} */
    this.runner = null;
    this.tiles = styles.map((style) => new Tile(style));
    get("tiles").append(...this.tiles.map(({ link }) => make("li", {}, link)));
    const seen = new IntersectionObserver((entries) => {
      for (const entry of entries) {
        const tile = this.tiles.find(({ link }) => link === entry.target);
        if (tile) tile.isVisible = entry.isIntersecting;
      }
      this.resume();
    });
    for (const { link } of this.tiles) seen.observe(link);
  }

  /** Shows finished pictures. @param {(name: string) => string} address of the picture of a style */
  showImages(address) {
    for (const tile of this.tiles) tile.showImage(address(tile.name));
  }

  /** Draws all pictures again. */
  restart() {
    for (const tile of this.tiles) tile.isStale = true;
    this.resume();
  }

  /** Continues to draw, if it does not already. */
  async resume() {
    if (this.#isDrawing || this.isPaused) return;
    this.#isDrawing = true;
    for (let tile = this.#next(); tile && !this.isPaused; tile = this.#next()) {
      tile.isStale = false;
      const { picture } = this.source;
      if (this.runner) await tile.draw(this.runner, this.source);
      if (this.source.picture !== picture) tile.isStale = true;
      if (!this.source.video) this.onprogress(this.tiles.filter(({ isStale }) => !isStale).length, this.tiles.length);
      await new Promise(requestAnimationFrame);
    }
    this.#isDrawing = false;
  }

  /** Returns the next tile to draw: a visible one, else any. */
  #next() {
    const stale = this.tiles.filter(({ isStale }) => isStale);
    const next = stale.find(({ isVisible }) => isVisible) ?? (this.source.video ? undefined : stale[0]);
    if (next || !this.source.video || (this.source.film?.paused ?? false)) return next;
    for (const tile of this.tiles) tile.isStale = tile.isVisible;
    return this.tiles.find(({ isStale }) => isStale);
  }
}
