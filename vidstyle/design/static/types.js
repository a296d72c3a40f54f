// Types of the messages from the server. The server holds the style; the page only shows it.

import { title } from "./elements.js";

/**
 * A parameter of a style and its control.
 * @typedef {object} Entry
 * @property {number | null} step the step that it belongs to; null: the style itself
 * @property {string} name
 * @property {string} label its name in plain words, in this style
 * @property {string} path as in `--set`
 * @property {"slider" | "switch" | "color" | "choice"} kind
 * @property {any} value
 * @property {any} default
 * @property {any} start the value when the style was opened or saved
 * @property {boolean} knob whether it is pinned to the style panel
 * @property {string} help
 * @property {number} [low]
 * @property {number} [high]
 * @property {boolean} [whole]
 * @property {string} [unit]
 * @property {string[]} [options]
 * @property {string} [none] what stands for an empty option
 * @property {string} about the label of its step; "" for the style
 * @property {"" | "picture" | "file"} [picks] the kind of the options
 */

/**
 * A step of the style.
 * @typedef {object} Step
 * @property {number} step its permanent number
 * @property {string} block
 * @property {string} label the name of the block in plain words
 * @property {string} kind
 * @property {string} help
 * @property {string} main its most important value, as text
 * @property {boolean} muted
 * @property {string} save
 * @property {boolean} aside whether its picture does not become the result: it is a mask, or blended in
 * @property {string} implied the name under which the block saves its output by default
 * @property {string} from
 * @property {string[]} from_options
 * @property {boolean} recipe
 * @property {Entry[]} entries
 * @property {string | null} error
 */

/** @typedef {"base" | "background" | "lines"} Layer */
/** @typedef {{from: number | "source", to: number, name: string, as: string}} Edge a saved picture that a step reads, as its input ("from") or a parameter */

/**
 * @typedef {object} State
 * @property {number} revision
 * @property {string | null} undo the edit that undo reverts
 * @property {string | null} redo the edit that redo applies again
 * @property {boolean} dirty whether there are unsaved changes
 * @property {string} file the file of the style; "" if it has none yet
 * @property {string} name
 * @property {string} note
 * @property {import("./variant_chip.js").Variant[]} variants
 * @property {string | null} variant the current variant, "" for the style without one; null if it has the values of none
 * @property {Entry[]} fields
 * @property {Entry[]} knobs
 * @property {{entry: number, label: string}[]} history
 * @property {number} present the current entry of the history
 * @property {("a" | "b")[]} snapshots the slots that hold a snapshot
 * @property {Record<Layer, Step[]>} layers
 * @property {Edge[]} edges
 * @property {string[]} errors
 */

/** @typedef {{name: string, label: string, category: string, help: string, explanation: string}} Block */
/** @typedef {{name: string, note: string, kinds: string[], aliases: string, words: string, has_name: boolean}} StyleInfo */

/** Returns the display name of a step: its block, or the picture that it saves. @param {Step} step */
export const nameOf = (step) => step.label || title(step.block || step.save || "Saved picture");

/** The display names of layers. @type {Record<Layer, string>} */
export const LAYER_NAMES = { base: "Prepare", background: "Colour", lines: "Lines" };

/** @type {Layer[]} */
export const LAYERS = ["base", "background", "lines"];

/** Returns all steps in the order in which they run. @param {State} state */
export function stepsOf(state) {
  return LAYERS.flatMap((layer) => state.layers[layer]);
}

/**
 * Returns the layer and index of a step.
 * @param {State} state
 * @param {number} step
 * @returns {{layer: Layer, index: number} | null}
 */
export function placeOf(state, step) {
  for (const layer of LAYERS) {
    const index = state.layers[layer].findIndex((each) => each.step === step);
    if (index >= 0) return { layer, index };
  }
  return null;
}
