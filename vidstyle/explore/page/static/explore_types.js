// Types of the messages from the server.

/**
 * @typedef {object} Clip
 * @property {string} name
 * @property {[number, number]} size width and height
 * @property {number[]} frames the numbers of the frames of the excerpt
 * @property {number} rate the frame rate of the excerpt
 * @property {number} fps the frame rate of the film
 * @property {number} count the number of all frames; 1 for a photograph
 * @property {boolean} render whether it can be rendered
 * @property {boolean} reveal whether files can be shown in their folders
 * @property {string} folder of the styles of the user
 * @property {string} output the folder of rendered films and exported files
 * @property {boolean} design whether the designer can be opened
 * @property {Target[]} targets
 */

/**
 * @typedef {object} Tile
 * @property {number} tile its number
 * @property {string} name
 * @property {"chosen" | "values" | "step" | "cross" | "wild" | "shipped" | "tuned" | "match"} kind how it was generated
 * @property {string[]} parents
 * @property {string} likeness the distance to the reference picture in words, or ""
 * @property {string} verdict its score, and what speaks for and against it, or ""
 * @property {string} fault why it is shown only for lack of better ones, or ""
 * @property {string} caption its name: what one sees of it; no other tile of this screen has it
 * @property {string} change how it differs from the chosen tile, in words; "" if it is not derived from it
 * @property {string} blocks the blocks that shape it most, in words
 * @property {string} steps the blocks that it has gained and lost, compared with the chosen tile, in words
 * @property {Object<string, string[]>} layers the blocks of each layer
 * @property {string} ink
 * @property {string} paper
 */

/**
 * @typedef {object} State
 * @property {number} at the number of the current screen
 * @property {Tile[]} tiles nine, or none until the first screen is ready
 * @property {number | null} taken the position that was chosen on this screen
 * @property {boolean} back
 * @property {boolean} forward
 * @property {number} near
 * @property {string[]} locks
 * @property {number[][]} history for each screen the tiles that represent it
 * @property {Tile[]} stars
 * @property {number} reference the number of reference pictures so far, of which the last one is shown
 */

/** @typedef {{kind: string, title: string, use: string, help: string}} Target a format for other programs */

/** @typedef {{key: string, values: number[], plan?: import("./runner.js").Plan}} PlanMessage */

export {};
