// The shapes and words of the bubbles of a comic, moved and stretched; vidstyle draws the final ones.

import { makeSvg } from "./elements.js";

/**
 * A balloon, a caption or another text of a panel.
 * @typedef {object} Bubble
 * @property {SVGGElement} group
 * @property {number} number in the document
 * @property {number[]} place left, top, right and bottom on its page
 * @property {number[]} first the place with which the page was loaded
 * @property {number[] | undefined} tip the end of its tail
 * @property {string} words
 * @property {string} firstWords
 * @property {number} size of its font
 * @property {number} firstSize
 * @property {boolean} inCapitals whether words are drawn in capitals
 * @property {[SVGPolygonElement, number[]][]} shapes with their points
 * @property {number} length of the longest line of the first words, as vidstyle has drawn it
 * @property {SVGTSpanElement[]} rows the lines of the words with which the page was loaded
 */

/** Distance between baselines, in font sizes. */
export const LINE_HEIGHT_RATIO = 1.2;
/** Width of the line that makes letters bold, in font sizes. */
const BOLD_LINE_RATIO = 1 / 14;
/** The distance of a baseline from the middle of its line, in font sizes. */
const BASELINE_RATIO = 0.3;

/** A part of a line that is stressed, or another part. */
const STRESSED = /\*(\w(?:[^*]*\w)?)\*/g;
const PARTS = new RegExp(`${STRESSED.source}|([^*]+|\\*)`, "g");

/** Parses the numbers of an attribute; undefined if it is missing. @param {string | null | undefined} text */
export const numbers = (text) => text?.split(/[ ,]/).map(Number);

/** Returns the bubble that a group of the page shows. @param {SVGGElement} group @param {number} number @param {string} words @param {boolean} inCapitals @returns {Bubble} */
export function readBubble(group, number, words, inCapitals) {
  const place = numbers(group.dataset.place) ?? [];
  const polygons = /** @type {SVGPolygonElement[]} */ ([...group.querySelectorAll("polygon")]);
  const rows = /** @type {SVGTSpanElement[]} */ ([...group.querySelectorAll("text > tspan")]);
  const size = Number(group.querySelector("text")?.getAttribute("font-size"));
  return {
    group, number, place, words, size, inCapitals, first: place, firstWords: words, firstSize: size,
    tip: numbers(group.dataset.tip),
    shapes: polygons.map((each) => [each, numbers(each.getAttribute("points")) ?? []]),
    length: Math.max(...rows.map((row) => Number(row.getAttribute("textLength")))),
    rows,
  };
}

const context = /** @type {CanvasRenderingContext2D} */ (document.createElement("canvas").getContext("2d"));

/** Returns the width of a line at the first size of the font that the browser has. @param {Bubble} bubble @param {string} line */
function shownWidth({ group, firstSize, inCapitals }, line) {
  context.font = `${firstSize}px ${getComputedStyle(group).fontFamily}`;
  const plain = line.replace(STRESSED, "$1");
  return context.measureText(inCapitals ? plain.toUpperCase() : plain).width;
}

/** Returns the width of a line as vidstyle draws it, if its font is missing here, too. @param {Bubble} bubble @param {string} line */
export function widthOf(bubble, line) {
  const before = Math.max(...bubble.firstWords.split("\n").map((each) => shownWidth(bubble, each)));
  const size = bubble.size / bubble.firstSize;
  return size * shownWidth(bubble, line) * (bubble.length && before ? bubble.length / before : 1);
}

/** Whether the words are centred in a round shape. @param {Bubble} bubble */
export const isRound = ({ group }) => group.matches(".balloon, .burst, .cloud, .whisper");

/** Returns the corners of a shape moved and stretched with its words; the tip of a tail stays. @param {Bubble} bubble @param {number[]} points */
function outline(bubble, points) {
  const [left, top, right, bottom] = bubble.first;
  const [x, y, xx, yy] = bubble.place;
  const corners = [];
  for (let at = 0; at < points.length; at += 2) {
    const [across, down] = [(points[at] - left) / (right - left), (points[at + 1] - top) / (bottom - top)];
    corners.push([x + across * (xx - x), y + down * (yy - y)]);
  }
  const { tip } = bubble;
  if (!tip || bubble.group.matches(".cloud")) return corners;
  // The second corner is the tip of the tail, between its roots, which are recomputed on the side of the tip.
  corners.splice(1, 1);
  const [middle, half] = [[(x + xx) / 2, (y + yy) / 2], Math.hypot(points[0] - points[4], points[1] - points[5]) / 2];
  const way = Math.hypot(tip[0] - middle[0], tip[1] - middle[1]) || 1;
  const [dx, dy] = [(tip[0] - middle[0]) / way, (tip[1] - middle[1]) / way];
  const isRoot = (/** @type {number[]} */ [px, py]) =>
    Math.abs((px - middle[0]) * dy - (py - middle[1]) * dx) <= half && (px - middle[0]) * dx + (py - middle[1]) * dy > 0;
  const start = corners.findIndex((each, at) => isRoot(each) && !isRoot(corners[(at || corners.length) - 1]));
  if (start < 0) return corners;
  const turned = [...corners.slice(start), ...corners.slice(0, start)];
  const count = turned.findIndex((each) => !isRoot(each));
  return [turned[0], tip, ...turned.slice(Math.max(1, count - 1))];
}

/** Shows a bubble at its place with its words. @param {Bubble} bubble */
export function draw(bubble) {
  const around = bubble.shapes.at(-1);
  // The circles of a thought do not move.
  if (around) around[0].setAttribute("points", outline(bubble, around[1]).join(" "));
  const { words, firstWords, group } = bubble;
  const rows = words === firstWords ? movedRows(bubble) : newRows(bubble);
  const text = group.querySelector("text");
  text?.setAttribute("font-size", String(bubble.size));
  text?.replaceChildren(...rows);
}

/** Returns the rows with which the page was loaded, moved with the middle of the bubble. @param {Bubble} bubble */
function movedRows({ rows, place, first }) {
  const by = [0, 1].map((axis) => (place[axis] + place[axis + 2] - first[axis] - first[axis + 2]) / 2);
  for (const row of rows) {
    row.dataset.first ??= `${row.getAttribute("x")} ${row.getAttribute("y")}`;
    const [x, y] = numbers(row.dataset.first) ?? [];
    row.setAttribute("x", String(x + by[0]));
    row.setAttribute("y", String(y + by[1]));
  }
  return rows;
}

/** Returns a row for each line of the words. @param {Bubble} bubble */
function newRows(bubble) {
  const [left, top, right, bottom] = bubble.place;
  const { size, first, rows, inCapitals } = bubble;
  const lines = bubble.words.split("\n");
  const inset = (numbers(rows[0].dataset.first) ?? [Number(rows[0].getAttribute("x"))])[0] - first[0];
  const anchor = isRound(bubble) ? { x: (left + right) / 2, "text-anchor": "middle" } : { x: left + inset };
  return lines.map((line, number) => {
    const y = (top + bottom) / 2 + (LINE_HEIGHT_RATIO * (number - (lines.length - 1) / 2) + BASELINE_RATIO) * size;
    const row = makeSvg("tspan", { ...anchor, y, textLength: widthOf(bubble, line), lengthAdjust: "spacingAndGlyphs" });
    const text = inCapitals ? line.toUpperCase() : line;
    for (const [, stressed, plain] of text.matchAll(PARTS)) {
      const part = makeSvg("tspan", stressed ? { stroke: "#000", "stroke-width": size * BOLD_LINE_RATIO } : {});
      part.textContent = stressed ?? plain;
      row.append(part);
    }
    return row;
  });
}
