// Commands on the selected step, from the mouse and the keyboard.

import { title } from "./elements.js";
import { LAYER_NAMES, LAYERS, nameOf, placeOf, stepsOf } from "./types.js";

/** @typedef {import("./types.js").Layer} Layer */
/** @typedef {import("./layout.js").CardName} CardName */

/** Adds, moves and changes steps, and announces each change. */
export class Steps {
  /** @type {CardName | null} */
  selected = null;
  /** Is called before a step is added. @type {() => void} */
  onadd = () => {};
  /** Is called to paste what was copied. @type {(layer: Layer, index: number) => void} */
  onpaste = () => {};
  /** Commands run one after another, each on the state that the previous one leaves. @type {Promise<unknown>} */
  #last = Promise.resolve();

  /**
   * @param {import("./session.js").Session} session
   * @param {import("./palette.js").Palette} palette
   * @param {(text: string, alarm?: boolean, visible?: boolean) => void} say
   * @param {() => void} onselect
   * @param {(name: CardName) => void} focus
   */
  constructor(session, palette, say, onselect, focus) {
    this.session = session;
    this.palette = palette;
    this.say = say;
    this.onselect = onselect;
    this.focus = focus;
  }

  /** The selected step, or null. */
  get step() {
    const { state } = this.session;
    return (state && stepsOf(state).find((step) => step.step === this.selected)) ?? null;
  }

  /** Selects a card and focuses it. @param {CardName} name */
  select(name) {
    this.selected = name;
    this.onselect();
    this.focus(name);
  }

  /** Selects the source if the selected step no longer exists; called after each new state. */
  deselectRemoved() {
    if (typeof this.selected === "number" && !this.step) this.selected = "source";
  }

  /**
   * Lets the user choose a block and adds it at a position.
   * @param {Layer | null} layer null: the one of its kind @param {number} index @param {DOMRect | null} near
   */
  add(layer, index, near) {
    this.palette.onpaste = () => this.onpaste(layer ?? "base", index);
    this.palette.open(layer ? `${LAYER_NAMES[layer]}, ${this.#placeText(layer, index)}` : "the style, in the row of its kind", near, async (block) => {
      const known = new Set(stepsOf(/** @type {import("./types.js").State} */ (this.session.state)).map(({ step }) => step));
      this.onadd();
      const answer = await this.session.edit("add", { layer: layer ?? "", index, block });
      const { state } = this.session;
      if (!answer || !state) return;
      const added = answer.step ?? stepsOf(state).find(({ step }) => !known.has(step))?.step;
      const place = added === undefined ? null : placeOf(state, added);
      if (added === undefined || !place) return;
      this.select(added);
      const name = this.step ? nameOf(this.step) : title(block);
      this.say(`${name} added to ${LAYER_NAMES[place.layer]}, position ${place.index + 1} of ${state.layers[place.layer].length}.`, false, false);
    });
  }

  /** Adds the step that puts the picture behind the lines; the button that asked for it is gone then. */
  async showBehindLines() {
    const answer = await this.session.edit("show_behind_lines", {});
    if (answer?.step !== undefined) this.select(answer.step);
  }

  /** Returns where a new step comes in its layer. @param {Layer} layer @param {number} index */
  #placeText(layer, index) {
    const before = index ? this.session.state?.layers[layer][index - 1] : null;
    return before ? `after “${nameOf(before)}”` : "as first step";
  }

  /** The position after the selected card. @returns {{layer: Layer, index: number} | null} */
  get placeAfter() {
    const { state } = this.session;
    if (!state) return null;
    if (this.selected === "source" || this.selected === null) return { layer: "base", index: 0 };
    if (this.selected === "base" || this.selected === "background" || this.selected === "lines") return { layer: this.selected, index: 0 };
    if (this.selected === "result") return { layer: "lines", index: state.layers.lines.length };
    const place = typeof this.selected === "number" ? placeOf(state, this.selected) : null;
    return place && { layer: place.layer, index: place.index + 1 };
  }

  /** Adds a step after the selected card; after the source of an empty style, to the layer of its kind. @param {DOMRect | null} near */
  addAfter(near) {
    const place = this.placeAfter, { selected } = this;
    const isFirst = place && (selected === "source" || selected === null) && !stepsOf(/** @type {import("./types.js").State} */ (this.session.state)).length;
    if (isFirst) return this.add(null, 0, near);
    if (place) this.add(place.layer, place.index, near);
  }

  /** @param {number} step @param {Layer} layer @param {number} index */
  async move(step, layer, index) {
    if (!(await this.session.edit("move", { step, layer, index }))) return;
    this.select(step);
    const { state } = this.session;
    if (state && this.step) this.say(`${nameOf(this.step)} moved to ${LAYER_NAMES[layer]}, position ${index + 1} of ${state.layers[layer].length}.`, false, false);
  }

  /** Runs a command after those before it. @param {() => unknown} run */
  #enqueue(run) {
    this.#last = this.#last.then(run);
    return this.#last;
  }

  /** Moves the selected step within its layer or to another. @param {string} key the arrow key */
  shift(key) {
    return this.#enqueue(() => this.#shift(key));
  }

  /** @param {string} key */
  #shift(key) {
    const { state } = this.session;
    const place = state && typeof this.selected === "number" && placeOf(state, this.selected);
    if (!state || !place || typeof this.selected !== "number") return this.say("Choose a step first.");
    const { layer, index } = place;
    const length = state.layers[layer].length;
    if (key === "ArrowLeft" && index > 0) return this.move(this.selected, layer, index - 1);
    if (key === "ArrowRight" && index < length - 1) return this.move(this.selected, layer, index + 1);
    const other = LAYERS[LAYERS.indexOf(layer) + ({ ArrowUp: -1, ArrowDown: 1 }[key] ?? 0)];
    if (other && other !== layer) return this.move(this.selected, other, Math.min(index, state.layers[other].length));
    this.say(`The step is ${key === "ArrowLeft" || key === "ArrowRight" ? "at the end of its layer" : "in the outermost layer"}.`);
  }

  mute() {
    return this.#enqueue(() => this.#mute());
  }

  async #mute() {
    const { step } = this;
    if (!step) return;
    if (await this.session.edit("mute", { step: step.step, on: !step.muted })) this.say(`${nameOf(step)} ${step.muted ? "unmuted" : "muted"}.`, false, false);
  }

  duplicate() {
    return this.#enqueue(() => this.#duplicate());
  }

  async #duplicate() {
    const { step } = this;
    if (!step) return;
    const answer = await this.session.edit("duplicate", { step: step.step });
    if (answer?.step !== undefined) this.select(answer.step);
    if (answer) this.say(`${nameOf(step)} duplicated.`, false, false);
  }

  expand() {
    return this.#enqueue(() => this.#expand());
  }

  async #expand() {
    const { step } = this;
    if (!step?.recipe) return;
    const { state } = this.session;
    const place = state && placeOf(state, step.step);
    if (!(await this.session.edit("expand", { step: step.step })) || !place) return;
    this.select(this.session.state?.layers[place.layer][place.index]?.step ?? "source");
    this.say(`${nameOf(step)} replaced with its steps.`, false, false);
  }

  remove() {
    return this.#enqueue(() => this.#remove());
  }

  async #remove() {
    const { step } = this;
    const { state } = this.session;
    const place = step && state && placeOf(state, step.step);
    if (!place) return this.say("Choose a step first.");
    const layer = state.layers[place.layer];
    const next = (layer[place.index + 1] ?? layer[place.index - 1])?.step ?? "source";
    if (!(await this.session.edit("remove", { step: step.step }))) return;
    this.select(next);
    this.say(`${nameOf(step)} removed.`, false, false);
  }

  /** @param {"undo" | "redo"} which */
  again(which) {
    return this.#enqueue(() => this.#again(which));
  }

  /** @param {"undo" | "redo"} which */
  async #again(which) {
    const label = this.session.state?.[which];
    if (!label) {
      this.say(`Nothing to ${which}.`);
      return;
    }
    if (await this.session.ask(which)) this.say(`${title(which)}: ${label}.`);
  }
}
