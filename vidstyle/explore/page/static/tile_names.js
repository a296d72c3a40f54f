// The names of tiles.

import { title } from "./elements.js";

/** @typedef {import("./explore_types.js").Tile} Tile */

/** Returns the name of a style without the suffix of its variation. @param {string} name */
function rootOf(name) {
  return name.split("~")[0].replace(/^(open|paper)-(\d+)$/, "random $2").replaceAll("_", " ");
}

/** Returns the name of a look: what one sees of it. @param {Tile} tile */
export function nameOf({ kind, name, caption }) {
  if (kind === "match") return title(rootOf(name));
  return kind === "tuned" ? `${caption}, tuned` : caption;
}

/** Describes in a line below its name what is wrong with a tile, where it comes from, or how it differs from the chosen one; "" for a look of the tuning pad. @param {Tile} tile */
export function summaryOf({ kind, parents, change, likeness, fault }) {
  if (fault && kind !== "chosen" && kind !== "match") return `${fault[0].toUpperCase()}${fault.slice(1)}`;
  const [one, other] = parents.map((parent) => title(rootOf(parent)));
  switch (kind) {
    case "chosen":
      return "Your choice";
    case "values":
    case "step":
      return change;
    case "cross":
      return /^Random \d+$/.test(other ?? one) ? "Mixed with another look" : `Mixed with ${other ?? one}`;
    case "shipped":
      return `From ${one}`;
    case "match":
      return likeness;
    case "tuned":
      return "";
    default:
      return "A surprise";
  }
}
