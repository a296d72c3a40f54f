// Runs of steps that make pictures for others, such as masks, folded into one card each: the main path stays short.

import { LAYERS, nameOf } from "./types.js";

/** @typedef {import("./types.js").Layer} Layer */
/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").Step} Step */

/** A shorter run is not folded. */
const MIN_FOLDED_STEPS = 2;

/**
 * What the diagram shows at one position of a layer.
 * @typedef {object} Item
 * @property {number | string} step the number of the step, or the name of a fold
 * @property {string} from as of its first step
 * @property {number} index of its first step in the layer
 * @property {Step[]} steps one step, or all steps of a fold
 */

/** @typedef {{items: Record<Layer, Item[]>, lengths: Record<Layer, number>, edges: {from: number | string, to: number | string, name: string}[]}} Folded */

/**
 * Folds a state; runs with the selected step, or with a mistake, stay open.
 * @param {State} state
 * @param {import("./layout.js").CardName | null} selected
 * @param {boolean} isWhole whether nothing is folded
 * @returns {Folded}
 */
export function fold(state, selected, isWhole) {
  /** @type {Record<string, Item[]>} */
  const items = {};
  /** @type {Map<number | string, number | string>} */
  const folds = new Map();
  for (const layer of LAYERS) {
    const runs = runsOf(state.layers[layer]);
    items[layer] = runs.flatMap(/** @returns {Item[]} */ (run) => {
      const open = isWhole || run.length < MIN_FOLDED_STEPS || run.some(({ step }) => step.step === selected || step.error || step.muted);
      if (open) return run.map(({ step, index }) => ({ step: step.step, from: step.from, index, steps: [step] }));
      const [{ step, index }] = run;
      const name = `fold-${step.step}`;
      for (const each of run) folds.set(each.step.step, name);
      return [{ step: name, from: step.from, index, steps: run.map((each) => each.step) }];
    });
  }
  const edges = straighten(/** @type {Record<Layer, Item[]>} */ (items), state.edges.map((edge) => ({ ...edge, from: folds.get(edge.from) ?? edge.from, to: folds.get(edge.to) ?? edge.to })));
  const lengths = { base: state.layers.base.length, background: state.layers.background.length, lines: state.layers.lines.length };
  return { items: /** @type {Record<Layer, Item[]>} */ (items), lengths, edges };
}

/**
 * Makes the input of a step part of the chain where only folds stand between; returns the other edges, one for each pair.
 * @param {Record<Layer, Item[]>} items @param {{from: number | string, to: number | string, name: string, as: string}[]} edges
 */
function straighten(items, edges) {
  const inputs = new Set();
  for (const layer of LAYERS) {
    for (const [place, item] of items[layer].entries()) {
      const edge = edges.find(({ to, as }) => to === item.step && as === "from");
      const before = [.../** @type {Item[]} */ (layer === "base" ? [] : items.base), ...items[layer].slice(0, place)];
      const last = before.findLastIndex(({ steps }) => steps.length === 1);
      if (!edge || !item.from || before[last]?.step !== edge.from) continue;
      inputs.add(edge);
      for (const each of [...before.slice(last + 1), item]) each.from = "";
    }
  }
  const seen = new Set();
  return edges.filter((edge) => {
    const key = `${edge.from} ${edge.to}`;
    return edge.from !== edge.to && !inputs.has(edge) && !seen.has(key) && seen.add(key);
  });
}

/** Splits a layer into runs of steps aside from the main path, and single steps on it. @param {Step[]} steps */
function runsOf(steps) {
  /** @type {{step: Step, index: number}[][]} */
  const runs = [];
  for (const [index, step] of steps.entries()) {
    const last = runs.at(-1);
    if (step.aside && last?.[0].step.aside) last.push({ step, index });
    else runs.push([{ step, index }]);
  }
  return runs;
}

/** Returns what the pictures of a fold are for; "" if that is not one step. @param {Folded} folded @param {Item} fold */
export function purposeOf({ items, edges }, fold) {
  const next = edges.find(({ from }) => from === fold.step)?.to;
  const user = LAYERS.flatMap((layer) => items[layer]).find(({ step, steps }) => step === next && steps.length === 1);
  return user ? `for ${nameOf(user.steps[0])}` : "";
}
