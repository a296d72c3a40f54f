// The values of a plan for the controls of a page. The effect of each control was recorded at export.

/** @typedef {import("./controls.js").Described & {path: string, value: any, help: string}} Entry a control and its value */
/** @typedef {{at: number[], set: {index: number, numbers: number[], nearest: boolean}[]}} Table the effect of a control on the values of a plan */
/** @typedef {import("./runner.js").Plan & {server: string[]}} Plan */
/** @typedef {{side: number, plan: Plan, tables: Record<string, Table[]>, style?: import("./runner.js").LoadedStyle}} SizedPlan a plan for pictures whose shorter side has `side` pixels */

/**
 * Interpolates linearly between the positions of a table, or extrapolates beyond its ends.
 * @param {number[]} at @param {number[]} numbers @param {number} position @param {boolean} nearest
 */
function interpolate(at, numbers, position, nearest) {
  let next = at.findIndex((each, number) => number > 0 && each >= position);
  if (next < 0) next = at.length - 1;
  const part = at.length > 1 ? (position - at[next - 1]) / (at[next] - at[next - 1]) : 0;
  if (nearest) return numbers[part < 0.5 ? next - 1 : next];
  return numbers[next - 1] + part * (numbers[next] - numbers[next - 1]);
}

/** Returns the positions of a value in the tables of its control. @param {Entry} entry @param {any} value @returns {number[]} */
function positionsOf({ kind, options = [] }, value) {
  if (kind === "color") return [1, 3, 5].map((from) => parseInt(value.slice(from, from + 2), 16));
  if (kind === "slider") return [value];
  return [kind === "switch" ? Number(value) : options.indexOf(value)];
}

/**
 * Returns the values of a plan; each control adds its difference.
 * @param {SizedPlan} sized @param {Entry[]} controls @param {Record<string, any>} values of the controls by path
 */
export function planValues({ plan, tables }, controls, values) {
  const numbers = [...plan.values];
  for (const entry of controls) {
    positionsOf(entry, values[entry.path]).forEach((position, axis) => {
      const { at, set } = tables[entry.path][axis];
      for (const { index, numbers: known, nearest } of set)
        numbers[index] += interpolate(at, known, position, nearest) - plan.values[index];
    });
  }
  return numbers;
}
