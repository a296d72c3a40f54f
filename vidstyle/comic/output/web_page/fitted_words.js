// Words broken into lines, and the place of a bubble around them.

import { LINE_HEIGHT_RATIO, widthOf } from "./bubble_shapes.js";

/** @typedef {import("./bubble_shapes.js").Bubble} Bubble */

/** New words may be wider than the old ones by this factor. */
const MAX_WIDTH_GAIN = 1.3;
/** A text that is longer than the old one gets at least this aspect ratio. */
const MIN_TEXT_ASPECT = 2.4;
/** Growth of the padding on each side with the words, so that a round shape contains their corners. @type {Record<string, number>} */
const PADDING_GROWTH = { balloon: 0.09, whisper: 0.09, cloud: 0.15, burst: 0.2 };
/** Halvings of an interval of widths. */
const SEARCH_STEPS = 12;

/** Returns lines of at most this width, unless a word is wider. @param {string[]} words @param {number} limit @param {(line: string) => number} measure */
function fill(words, limit, measure) {
  const lines = [words[0]];
  for (const word of words.slice(1)) {
    const longer = `${lines[lines.length - 1]} ${word}`;
    if (measure(longer) <= limit) lines[lines.length - 1] = longer;
    else lines.push(word);
  }
  return lines;
}

/** Returns lines of at most this width that are about equally long. @param {string} text @param {number} limit @param {(line: string) => number} measure */
function wrap(text, limit, measure) {
  const words = text.split(" ");
  const { length } = fill(words, limit, measure);
  let [low, high] = [0, limit];
  for (let step = 0; step < SEARCH_STEPS; step++) {
    const middle = (low + high) / 2;
    if (fill(words, middle, measure).length > length) low = middle;
    else high = middle;
  }
  return fill(words, high, measure);
}

/**
 * Returns words in lines, and the place for them around the same middle. Lines remain as typed if none is too wide.
 * @param {Bubble} bubble
 * @param {string} typed
 */
export function fitWords(bubble, typed) {
  const measure = (/** @type {string} */ line) => widthOf(bubble, line);
  const extent = (/** @type {string[]} */ lines) => [Math.max(...lines.map(measure)), bubble.size * (LINE_HEIGHT_RATIO * (lines.length - 1) + 1)];
  const [given, before] = [typed.split("\n"), extent(bubble.firstWords.split("\n"))];
  const flat = given.join(" ");
  const limit = Math.max(MAX_WIDTH_GAIN * before[0], Math.sqrt(MIN_TEXT_ASPECT * LINE_HEIGHT_RATIO * bubble.size * measure(flat)));
  const lines = given.every((line) => measure(line) <= limit) ? given : wrap(flat, limit, measure);
  const { first, place, group } = bubble;
  const growth = PADDING_GROWTH[Object.keys(PADDING_GROWTH).find((kind) => group.matches(`.${kind}`)) ?? ""] ?? 0;
  const halves = extent(lines).map((length, axis) => (first[axis + 2] - first[axis]) / 2 + (0.5 + growth) * (length - before[axis]));
  const middle = [0, 1].map((axis) => (place[axis] + place[axis + 2]) / 2);
  return { words: lines.join("\n"), place: [...middle.map((at, axis) => at - halves[axis]), ...middle.map((at, axis) => at + halves[axis])] };
}

/** Returns a place moved into a box as far as it fits. @param {number[]} place @param {{x: number, y: number, width: number, height: number}} box */
export function moveInto(place, { x, y, width, height }) {
  const ends = [x, y, x + width, y + height];
  const by = [0, 1].map((axis) => {
    const [back, on] = [ends[axis] - place[axis], ends[axis + 2] - place[axis + 2]];
    return back > on ? (back + on) / 2 : Math.min(on, Math.max(back, 0));
  });
  return place.map((side, at) => side + by[at % 2]);
}
