// The tuning pad: a field of samples on which a point sets the two values that change a look most.

import { followPointer, get, make } from "./elements.js";
import { WaitingNote } from "./waiting_note.js";

/** @typedef {import("./explore_types.js").Tile} Tile */
/** @typedef {import("./painters.js").Subject} Subject */
/** @typedef {{label: string, path: string, low: number, high: number, whole: boolean, factor: boolean}} Axis */
/** @typedef {(kind: string, fields?: object) => Promise<any>} Ask */

/** How far an arrow key moves the point, without and with the Shift key: parts of the pad. */
const [STEP_RATIO, LARGE_STEP_RATIO] = [0.02, 0.1];
const pad = get("pad");
const point = get("point");

/** Returns the value at a position on an axis. @param {Axis} axis @param {number} place */
function valueAt(axis, place) {
  if (axis.factor) return axis.low * Math.pow(axis.high / axis.low, place);
  const value = axis.low + place * (axis.high - axis.low);
  return axis.whole ? Math.round(value) : value;
}

/** Tunes one look. */
export class TuningPad {
  /** The look that is tuned. @type {Tile | null} */
  tile = null;
  /** The position of the point. @type {[number, number]} */
  at = [0.5, 0.5];
  /** Whether the point has left the position of the style. */
  moved = false;
  /** None until they are found. @type {Axis[]} */
  #axes = [];
  #note = new WaitingNote(get("pad-note"));

  /** @param {Ask} ask @param {() => void} onmove is called when the point has moved */
  constructor(ask, onmove) {
    this.ask = ask;
    this.onmove = onmove;
    followPointer(pad, (event) => {
      const box = pad.getBoundingClientRect();
      this.#moveTo((event.clientX - box.left) / box.width, 1 - (event.clientY - box.top) / box.height);
    });
  }

  /** Finds two values of a look and shows samples of them. @param {Tile} tile */
  async load(tile) {
    this.tile = tile;
    this.moved = false;
    this.#axes = [];
    pad.classList.remove("ready");
    pad.setAttribute("aria-busy", "true");
    this.#note.begin("Finding two values to tune…");
    get("axes").replaceChildren();
    point.hidden = true;
    try {
      const { axes, start } = await this.ask("pad", { tile: tile.tile });
      if (this.tile !== tile) return;
      [this.#axes, this.at] = [axes, start];
      const samples = /** @type {HTMLImageElement} */ (get("samples"));
      samples.src = `pad.jpg?tile=${tile.tile}`;
      this.#placePoint();
      this.#note.begin("Drawing samples of both values…");
      await samples.decode();
      if (this.tile !== tile) return;
      this.#note.end("");
      pad.classList.add("ready");
    } catch (error) {
      if (this.tile === tile) this.#note.end("This look has no two values to tune.");
    }
    pad.setAttribute("aria-busy", "false");
  }

  /** The look with the values of the point. @returns {Subject | null} */
  get subject() {
    if (!this.tile) return null;
    const { tile: { tile }, at: [x, y] } = this;
    return {
      name: `${tile}@${x},${y}`,
      plan: (side, whole) => this.ask("tune", { tile, x, y, side, whole }),
      address: (frame, side) => `tuned.jpg?tile=${tile}&x=${x}&y=${y}&frame=${frame}&side=${side}`,
    };
  }

  /** Resolves to the number of a new tile with the values of the point. @returns {Promise<number>} */
  async keep() {
    const { tile } = await this.ask("keep", { tile: this.tile?.tile, x: this.at[0], y: this.at[1] });
    this.moved = false;
    return tile;
  }

  /** Moves the point by an arrow key; returns whether the key is one. @param {KeyboardEvent} event */
  press({ target, key, shiftKey }) {
    const step = shiftKey ? LARGE_STEP_RATIO : STEP_RATIO;
    const move = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] }[key];
    if (target !== pad || !move) return false;
    this.#moveTo(this.at[0] + move[0], this.at[1] + move[1]);
    return true;
  }

  /** @param {number} x @param {number} y */
  #moveTo(x, y) {
    if (!this.#axes.length) return;
    const inside = (/** @type {number} */ part) => Math.min(1, Math.max(0, part));
    this.at = [inside(x), inside(y)];
    this.moved = true;
    this.#placePoint();
    this.onmove();
  }

  #placePoint() {
    const [x, y] = this.at;
    point.hidden = false;
    // At an edge it stays whole.
    const within = (/** @type {number} */ part) => `clamp(.75rem, ${100 * part}%, 100% - .75rem)`;
    Object.assign(point.style, { left: within(x), top: within(1 - y) });
    const texts = this.#axes.map((axis, each) => [
      `${each ? "↑" : "→"} ${axis.label}`,
      String(Number(valueAt(axis, this.at[each]).toPrecision(3))),
    ]);
    get("axes").replaceChildren(...texts.flatMap(([name, value]) => [make("dt", { textContent: name }), make("dd", { textContent: value })]));
    pad.setAttribute("aria-description", texts.map((each) => each.join(" ")).join(", "));
  }
}
