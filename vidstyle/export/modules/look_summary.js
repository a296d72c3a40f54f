// The description of a look in a few words, for its tile.

import { title } from "./elements.js";

/** A part of a description that is shorter says nothing that the name does not say. */
const MIN_SUMMARY_LENGTH = 20;

/** Returns a text up to a comma, if that is long enough. @param {string} text */
function beginningOf(text) {
  const [begun, ...parts] = text.split(", ");
  return parts.reduce((whole, part) => (whole.length < MIN_SUMMARY_LENGTH ? `${whole}, ${part}` : whole), begun);
}

/** Two lines of a tile hold this many letters. */
const MAX_SUMMARY_LENGTH = 62;
/** Words at which a longer description ends. */
const DETAIL = /,? (?:with|where|that|whose|in strokes) /;

/** Returns a text without its details if it is too long for a tile. @param {string} text */
function shortened(text) {
  const [begun] = text.split(DETAIL);
  return text.length > MAX_SUMMARY_LENGTH && begun.length >= MIN_SUMMARY_LENGTH ? begun : text;
}

/** Returns the part of a description that says most in a few words. @param {string} note */
export function summaryOf(note) {
  const [first, second] = note.replace(/\.$/, "").split(/[:.;]\s/);
  return shortened(first.length < MIN_SUMMARY_LENGTH && second ? title(beginningOf(second)) : first);
}
