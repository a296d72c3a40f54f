// Words broken into lines, and the place of a bubble around them.

import { isRound, LINE_HEIGHT_RATIO, widthOf } from "./bubble_shapes.js";

/** @typedef {import("./bubble_shapes.js").Bubble} Bubble */

/** New words may be wider than the old ones by this factor. */
const MAX_WIDTH_GAIN = 1.3;
/** A text that is longer than the old one gets at least this aspect ratio. */
const MIN_TEXT_ASPECT = 2.4;
/** Growth of the padding on each side with the words, so that a round shape contains their corners. @type {Record<string, number>} */
const PADDING_GROWTH = { balloon: 0.09, whisper: 0.09, cloud: 0.15, burst: 0.2 };
/** The smallest letters of a text that is too long for its panel, relative to the first ones. */
const MIN_LETTERS_RATIO = 0.6;
/** Distance of words from the outer edge of the frame of their panel, in widths of its line. */
const MARGIN_RATIO = 1.5;
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
 * @typedef {{x: number, y: number, width: number, height: number}} Room
 */

/** Returns the part of its panel in which a bubble may stand: inside the frame, and between slanted edges. @param {Bubble} bubble @returns {Room | undefined} */
export function roomOf({ group }) {
  const panel = /** @type {SVGGElement | null} */ (group.closest(".panel"));
  const frame = /** @type {SVGGraphicsElement | null | undefined} */ (panel?.querySelector(".frame"));
  if (!frame) return undefined;
  const { x, y, width, height } = frame.getBBox();
  const corners = frame instanceof SVGPolygonElement ? [...frame.points].map((corner) => corner.x).sort((one, other) => one - other) : [];
  const [left, right] = corners.length ? corners.slice(1, 3) : [x, x + width];
  const margin = MARGIN_RATIO * Number(panel?.dataset.border);
  return { x: left + margin, y: y + margin, width: right - left - 2 * margin, height: height - 2 * margin };
}

/**
 * Returns words in lines, the size of their letters, and their place: in the room, with smaller letters if they need it.
 * @param {Bubble} bubble
 * @param {string} typed
 * @param {Room} [room]
 */
export function fitWords(bubble, typed, room) {
  for (let size = bubble.firstSize; ; size--) {
    const { words, place } = fitLetters({ ...bubble, size }, typed, room);
    const [wide, high] = [place[2] - place[0], place[3] - place[1]];
    const isSmallest = size - 1 < MIN_LETTERS_RATIO * bubble.firstSize;
    if (!room || isSmallest || (wide <= room.width && high <= room.height)) return { words, size, place: room ? moveInto(place, room) : place };
  }
}

/** Returns the width and height of lines. @param {Bubble} bubble @param {string[]} lines */
const extentOf = (bubble, lines) => [Math.max(...lines.map((line) => widthOf(bubble, line))), bubble.size * (LINE_HEIGHT_RATIO * (lines.length - 1) + 1)];

/**
 * Returns words in lines, and the place for them around the same middle; a box grows away from the nearer edge of the room.
 * Typed lines are kept if all of them are narrow enough.
 * @param {Bubble} bubble
 * @param {string} typed
 * @param {Room} [room]
 */
function fitLetters(bubble, typed, room) {
  const measure = (/** @type {string} */ line) => widthOf(bubble, line);
  const before = extentOf({ ...bubble, size: bubble.firstSize }, bubble.firstWords.split("\n"));
  const given = typed.split("\n");
  const flat = given.join(" ");
  const limit = Math.max(MAX_WIDTH_GAIN * before[0], Math.sqrt(MIN_TEXT_ASPECT * LINE_HEIGHT_RATIO * bubble.size * measure(flat)));
  const lines = given.every((line) => measure(line) <= limit) ? given : wrap(flat, limit, measure);
  const { first, place, group } = bubble;
  const growth = PADDING_GROWTH[Object.keys(PADDING_GROWTH).find((kind) => group.matches(`.${kind}`)) ?? ""] ?? 0;
  const halves = extentOf(bubble, lines).map((length, axis) => (first[axis + 2] - first[axis]) / 2 + (0.5 + growth) * (length - before[axis]));
  const middle = [0, 1].map((axis) => (place[axis] + place[axis + 2]) / 2);
  if (room && !isRound(bubble)) middle[1] = middle[1] < room.y + room.height / 2 ? place[1] + halves[1] : place[3] - halves[1];
  return { words: lines.join("\n"), place: [...middle.map((at, axis) => at - halves[axis]), ...middle.map((at, axis) => at + halves[axis])] };
}

/** Returns a place moved into a box as far as it fits. @param {number[]} place @param {Room} box */
export function moveInto(place, { x, y, width, height }) {
  const ends = [x, y, x + width, y + height];
  const by = [0, 1].map((axis) => {
    const [back, on] = [ends[axis] - place[axis], ends[axis + 2] - place[axis + 2]];
    return back > on ? (back + on) / 2 : Math.min(on, Math.max(back, 0));
  });
  return place.map((side, at) => side + by[at % 2]);
}
