/**
 * What the server sends; it holds the style, the page only shows it.
 *
 * @module
 */

import { title } from "./elements.js";

/**
 * One value of a style and the control that sets it.
 * @typedef {object} Entry
 * @property {number | null} step the step that has it; null: the style itself
 * @property {string} name
 * @property {string} path as for `--set`
 * @property {"slider" | "switch" | "color" | "choice"} kind
 * @property {any} value
 * @property {any} default
 * @property {boolean} knob whether it stands in the simple view
 * @property {string} help
 * @property {number} [low]
 * @property {number} [high]
 * @property {boolean} [whole]
 * @property {string} [unit]
 * @property {string[]} [options]
 * @property {string} about the step that it belongs to; "" for the style
 * @property {"" | "picture" | "file"} [picks] what the options are
 */

/**
 * A step of the style.
 * @typedef {object} Step
 * @property {number} step its identity, which it keeps
 * @property {string} block
 * @property {string} kind
 * @property {string} help
 * @property {string} main its most telling value
 * @property {boolean} muted
 * @property {string} save
 * @property {string} implied the name under which the block itself saves
 * @property {string} from
 * @property {string[]} from_options
 * @property {boolean} recipe
 * @property {Entry[]} entries
 * @property {string | null} error
 */

/** @typedef {"base" | "background" | "lines"} Layer */
/** @typedef {{from: number | "source", to: number, name: string}} Edge a saved picture that a step uses */

/**
 * @typedef {object} State
 * @property {number} revision
 * @property {string | null} undo what undo takes back
 * @property {string | null} redo
 * @property {boolean} dirty whether there is anything to save
 * @property {string} file where it is saved; "" for nowhere yet
 * @property {string} name
 * @property {string} note
 * @property {string[]} variants
 * @property {string} variant the variant that the style is, or ""
 * @property {Entry[]} fields
 * @property {Entry[]} knobs
 * @property {{entry: number, label: string}[]} history
 * @property {number} present the entry of the history at which the document stands
 * @property {("a" | "b")[]} snapshots that are kept
 * @property {Record<Layer, Step[]>} layers
 * @property {Edge[]} edges
 * @property {string[]} errors
 */

/** @typedef {{name: string, kind: string, help: string, picture: string}} Block */
/** @typedef {{name: string, note: string, picture: string}} StyleInfo */

/** What a step is called: by its block, or by the picture that it saves. @param {Step} step */
export const nameOf = (step) => title(step.block || step.save || "Saved picture");

/** @type {Layer[]} */
export const LAYERS = ["base", "background", "lines"];

/** All steps, in the order in which they run. @param {State} state */
export function stepsOf(state) {
  return LAYERS.flatMap((layer) => state.layers[layer]);
}

/**
 * Where a step stands.
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
