// The description of a look in a few words, for its tile.

import { title } from "./elements.js";

/** A part of a description that is shorter says nothing that the name does not say. */
const MIN_SUMMARY_LENGTH = 20;

/** Returns a text up to a comma, if that is long enough. @param {string} text */
function beginningOf(text) {
  const [begun, ...parts] = text.split(", ");
  return parts.reduce((whole, part) => (whole.length < MIN_SUMMARY_LENGTH ? `${whole}, ${part}` : whole), begun);
}

/** Returns the part of a description that says most in a few words. @param {string} note */
export function summaryOf(note) {
  const [first, second] = note.replace(/\.$/, "").split(/[:.;]\s/);
  return first.length < MIN_SUMMARY_LENGTH && second ? title(beginningOf(second)) : first;
}
