/**
 * What the server tells the page.
 *
 * @module
 */

/**
 * @typedef {object} Clip
 * @property {string} name
 * @property {[number, number]} size width and height
 * @property {number[]} frames the numbers of the frames that move in the tiles
 * @property {number} rate how many of them are shown in a second
 * @property {number} count of all frames; 1 for a photograph
 * @property {boolean} render whether it can be rendered
 * @property {boolean} design whether the designer can be opened
 * @property {string} folder where films and exports are written
 */

/**
 * @typedef {object} Tile
 * @property {number} tile its number
 * @property {string} name
 * @property {"chosen" | "values" | "step" | "cross" | "wild" | "shipped" | "tuned"} kind how it came about
 * @property {string[]} parents
 * @property {Object<string, string[]>} layers the blocks of each layer
 * @property {string} ink
 * @property {string} paper
 */

/**
 * @typedef {object} State
 * @property {number} at the number of the screen that is shown
 * @property {Tile[]} tiles nine, or none while the first screen is made
 * @property {number | null} taken the place that was taken on this screen
 * @property {boolean} back
 * @property {boolean} forward
 * @property {number} near
 * @property {string[]} locks
 * @property {number[][]} history for each screen the tiles that stand for it
 * @property {Tile[]} stars
 */

/** @typedef {{key: string, values: number[], plan?: import("./runner.js").Plan}} PlanMessage */

export {};
