// The grid of nine tiles and its keyboard navigation.

import { icon, make, press, resize } from "./elements.js";
import { fetchPicture } from "./source_frames.js";
import { nameOf, summaryOf } from "./tile_names.js";

/** @typedef {import("./explore_types.js").Tile} Tile */
/** @typedef {import("./painters.js").Subject} Subject */

const TILE_COUNT = 9;
/** The place of the chosen tile. */
const MIDDLE = 4;
/** A narrower stage has two columns and scrolls. */
const MIN_WIDTH_PX = 480;
/** Lower tiles would not show a look; the stage scrolls. */
const MIN_HEIGHT_PX = 96;
const GAP_PX = 12;
/** What a star has done is said for this time. */
const CONFIRM_MS = 2000;
/** Names of looks have this space, if the stage has it, below pictures that are narrower. */
const MIN_NAME_WIDTH_PX = 300;
/** For that, a picture loses no more than the rest of its height. */
const MIN_SHOWN_RATIO = 0.8;
/** The name of a look next to an upright picture has this space. */
const [MIN_BESIDE_WIDTH_PX, MAX_BESIDE_WIDTH_PX] = [140, 220];

/** Returns a button with an icon and words. @param {Parameters<typeof icon>[0]} name @param {string} words @param {object} properties */
const labelled = (name, words, properties) => make("button", { disabled: true, ...properties }, icon(name), make("span", { textContent: words }));

/** The grid of tiles. */
export class Tiles {
  /** The number of columns. */
  columns = 3;
  /** The tiles by position. @type {Tile[]} */
  shown = [];
  /** Whether the picture of the chosen tile is in the middle already, before its screen has arrived. */
  #isMoved = false;
  /** Moves that picture, after the animation. @type {ReturnType<typeof setTimeout> | undefined} */
  #moving;
  /** Ends what stars say. @type {ReturnType<typeof setTimeout> | undefined} */
  #saying;

  /**
   * @param {HTMLElement} element
   * @param {object} handlers
   * @param {(place: number) => void} handlers.ontake
   * @param {(place: number) => void} handlers.onstar
   * @param {(place: number) => void} handlers.onenlarge
   */
  constructor(element, { ontake, onstar, onenlarge }) {
    this.element = element;
    this.cells = Array.from({ length: TILE_COUNT }, (_, place) => {
      const canvas = make("canvas", { width: 16, height: 9 });
      const tag = make("span", { className: "tag", ariaHidden: "true" });
      const take = make("button", { className: "take", disabled: true, onclick: () => ontake(place) }, canvas, tag);
      take.setAttribute("aria-keyshortcuts", String(place + 1));
      take.setAttribute("aria-label", `Tile ${place + 1}, not ready`);
      take.title = "Nine more like this";
      const star = make("button", { disabled: true, className: "plain", title: "Keep this look for later (S)", onclick: () => onstar(place) }, icon("star"));
      const enlarge = labelled("enlarge", "Open", { title: "Open: fine tuning, save, render (Z)", onclick: () => onenlarge(place) });
      const tools = make("div", { className: "tools" }, enlarge, star);
      const name = make("p", { className: "name" });
      const summary = make("p", { className: "summary quiet" });
      const number = make("kbd", { textContent: String(place + 1) });
      // The whole card is a button, except for the tools in it.
      const onclick = (/** @type {MouseEvent} */ { target }) => tools.contains(/** @type {Node} */ (target)) || take.click();
      const caption = make("div", { className: "caption", onclick }, number, make("div", { className: "words" }, name, summary), tools);
      const cell = make("div", { className: place === MIDDLE ? "tile middle waiting draft" : "tile waiting draft" }, take, caption);
      element.append(cell);
      return { cell, canvas, tag, take, star, enlarge, name, summary };
    });
  }

  /** Shows a picture in a tile that is not ready. @param {number} place @param {ImageBitmap} picture @param {string} [name] of a picture that is no candidate */
  sketch(place, picture, name = "") {
    const { cell, canvas, tag } = this.cells[place];
    tag.textContent = name;
    resize(canvas, [picture.width, picture.height]);
    canvas.getContext("2d")?.drawImage(picture, 0, 0);
    cell.classList.add("sketched", "draft");
    cell.classList.toggle("exact", Boolean(name));
  }

  /**
   * Replaces the tiles.
   * @param {Tile[]} tiles
   * @param {Set<number>} kept
   */
  show(tiles, kept) {
    clearTimeout(this.#moving); // a search that was cancelled at once
    const before = this.shown;
    this.shown = tiles;
    this.element.classList.remove("leaving");
    for (const [place, tile] of tiles.entries()) {
      const { cell, tag, take, star, enlarge, name, summary } = this.cells[place];
      const isShown = place === MIDDLE && tile.kind === "chosen" && this.#isMoved;
      // After a search that was cancelled, faded tiles have to come back, and the middle has its own picture again.
      const isLost = cell.classList.contains("waiting") || (place === MIDDLE && this.#isMoved);
      if (!isShown && (isLost || before[place]?.tile !== tile.tile)) {
        cell.classList.add("waiting", "draft");
        this.#preview(place);
      }
      tag.textContent = "";
      cell.classList.remove("sketched", "exact");
      cell.classList.toggle("chosen", tile.kind === "chosen");
      name.textContent = name.title = nameOf(tile);
      summary.textContent = summaryOf(tile);
      summary.title = tile.verdict;
      for (const button of [take, star, enlarge]) button.disabled = false;
      take.setAttribute("aria-label", `${place + 1}: ${[nameOf(tile), summaryOf(tile)].filter(Boolean).join(". ")}`);
      press(star, kept.has(tile.tile));
      star.setAttribute("aria-label", `Keep tile ${place + 1}`);
      enlarge.setAttribute("aria-label", `Open tile ${place + 1}`);
    }
    this.#isMoved = false;
    this.#place();
  }

  /** Shows the chosen tile first in two columns, which have no middle tile; also while the others fade. */
  #place() {
    const isChosen = this.element.classList.contains("leaving") || this.shown[MIDDLE]?.kind === "chosen";
    const cells = this.cells.map(({ cell }) => cell);
    const order = isChosen && this.columns < 3 ? [cells[MIDDLE], ...cells.filter((cell) => cell !== cells[MIDDLE])] : cells;
    if (order.every((cell, place) => this.element.children[place] === cell)) return;
    const focused = /** @type {HTMLElement | null} */ (document.activeElement);
    this.element.append(...order); // a moved tile loses the focus
    if (focused && this.element.contains(focused)) focused.focus({ preventScroll: true });
  }

  /** Shows the thumbnail of a tile until the tile is drawn. @param {number} place */
  async #preview(place) {
    const { cell, canvas } = this.cells[place];
    const { tile } = this.shown[place];
    const picture = await fetchPicture(`look.jpg?tile=${tile}`).catch(() => null);
    if (!picture || this.shown[place].tile !== tile || !cell.classList.contains("waiting")) return;
    [canvas.width, canvas.height] = [picture.width, picture.height];
    canvas.getContext("2d")?.drawImage(picture, 0, 0);
    this.ready(place, true);
  }

  /** The number of tiles that are drawn at their size. */
  get drawn() {
    return this.cells.filter(({ cell }) => !cell.matches(".draft")).length;
  }

  /** Marks a tile as drawn. @param {number} place @param {boolean} [isDraft] */
  ready(place, isDraft = false) {
    this.cells[place].cell.classList.remove("waiting", ...(isDraft ? [] : ["draft"]));
  }

  /** Returns the height of the captions below pictures. @param {number} across the width of a tile */
  #captionHeight(across) {
    this.element.classList.remove("beside");
    this.element.style.setProperty("--columns", String(this.columns));
    this.element.style.setProperty("--column", `${across}px`);
    return /** @type {HTMLElement} */ (this.element.querySelector(".caption")).offsetHeight;
  }

  /** Fits the tiles into the available space. @param {number} aspect width by height */
  fit(aspect) {
    const { clientWidth, clientHeight } = /** @type {HTMLElement} */ (this.element.parentElement);
    this.columns = clientWidth < MIN_WIDTH_PX ? 2 : 3;
    this.#place();
    const across = (clientWidth - GAP_PX * (this.columns + 1)) / this.columns;
    const caption = this.#captionHeight(across);
    const lead = /** @type {HTMLElement} */ (this.element.previousElementSibling).offsetHeight;
    const row = (clientHeight - lead - 3 * GAP_PX) / 3;
    const isBeside = this.columns > 2 && aspect <= 1 && across - row * aspect >= MIN_BESIDE_WIDTH_PX;
    const high = Math.max(MIN_HEIGHT_PX, isBeside ? row : row - caption);
    const down = this.columns < 3 ? Infinity : high * aspect;
    const whole = Math.min(across, down);
    const named = Math.max(whole, Math.min(MIN_NAME_WIDTH_PX, whole / MIN_SHOWN_RATIO));
    const width = Math.floor(isBeside ? whole : Math.min(across, named));
    const height = Math.floor(whole / aspect);
    this.element.classList.toggle("beside", isBeside);
    this.size = [Math.max(40, width), Math.max(40, Math.floor(width / aspect))];
    this.element.style.setProperty("--column", `${isBeside ? Math.floor(Math.min(across, width + MAX_BESIDE_WIDTH_PX)) : width}px`);
    this.element.style.setProperty("--width", `${this.size[0]}px`);
    this.element.style.setProperty("--height", `${Math.max(40, height)}px`);
  }

  /** The position of the tile with the focus or under the mouse; -1 if there is none. */
  get current() {
    const focused = this.cells.findIndex(({ cell }) => cell.contains(document.activeElement));
    return focused >= 0 ? focused : this.cells.findIndex(({ cell }) => cell.matches(":hover"));
  }

  /** Moves the focus to the nearest tile in a direction. @param {string} key the arrow key */
  go(key) {
    const now = this.current;
    if (now < 0) return this.cells[MIDDLE].take.focus();
    const [x, y] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[key] ?? [0, 0];
    const centres = this.cells.map(({ cell }) => cell.getBoundingClientRect()).map(({ left, top, width, height }) => [left + width / 2, top + height / 2]);
    const costs = centres.map(([across, down]) => {
      const [right, below] = [across - centres[now][0], down - centres[now][1]];
      const [along, aside] = [x * right + y * below, Math.abs(x * below + y * right)];
      // A row below may begin farther to the side; a column has its own row only.
      return along < 1 || (x && aside > 1) ? Infinity : along + aside;
    });
    const nearest = Math.min(...costs);
    if (nearest < Infinity) this.cells[costs.indexOf(nearest)].take.focus();
  }

  /** Marks whether a tile is kept. @param {number} place @param {boolean} isKept */
  mark(place, isKept) {
    press(this.cells[place].star, isKept);
  }

  /** Says for a moment at the star of a tile what it has done; the tile may have left the screen. @param {number} place @param {string} text */
  confirm(place, text) {
    const star = this.cells[place]?.star;
    if (!star) return;
    star.dataset.said = text;
    clearTimeout(this.#saying);
    this.#saying = setTimeout(() => this.cells.forEach((cell) => delete cell.star.dataset.said), CONFIRM_MS);
  }

  /** Moves the chosen tile to the middle, under its own name, and fades the others. @param {number} place @param {boolean} isKept */
  leave(place, isKept) {
    this.element.classList.add("leaving");
    this.#place();
    this.mark(MIDDLE, isKept);
    if (this.cells[place].cell.contains(document.activeElement)) this.cells[MIDDLE].take.focus();
    const middle = this.cells[MIDDLE].cell.getBoundingClientRect();
    const reduced = matchMedia("(prefers-reduced-motion: reduce)").matches;
    for (const [each, { cell }] of this.cells.entries()) {
      if (each !== place) cell.classList.add("waiting");
      else if (!reduced) {
        const from = cell.getBoundingClientRect();
        const [x, y] = [middle.left - from.left, middle.top - from.top];
        cell.style.zIndex = "2";
        cell.animate({ transform: ["none", `translate(${x}px, ${y}px)`] }, { duration: 240, easing: "ease-in-out" }).onfinish = () => (cell.style.zIndex = "");
      }
    }
    const [from, to] = [this.cells[place].canvas, this.cells[MIDDLE].canvas];
    const picture = make("canvas", { width: from.width, height: from.height });
    picture.getContext("2d")?.drawImage(from, 0, 0);
    const isDraft = this.cells[place].cell.classList.contains("draft");
    const { name, summary } = this.cells[MIDDLE];
    const chosen = this.shown[place];
    this.#moving = setTimeout(() => {
      this.#isMoved = true;
      [name.textContent, name.title, summary.textContent] = [nameOf(chosen), "", "Your choice"];
      this.cells[MIDDLE].cell.classList.remove("waiting");
      if (from === to) return;
      resize(to, [picture.width, picture.height]);
      to.getContext("2d")?.drawImage(picture, 0, 0);
      this.cells[MIDDLE].cell.classList.toggle("draft", isDraft);
      this.cells[place].cell.classList.add("waiting");
    }, reduced ? 0 : 235);
  }
}
