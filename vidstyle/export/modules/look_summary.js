// The description of a look in a few words, for its tile.

import { title } from "./elements.js";

/** A part of a description that is shorter says nothing that the name does not say. */
const MIN_SUMMARY_LENGTH = 20;

/** Returns the part of a description that says most in a few words. @param {string} note */
export function summaryOf(note) {
  const [first, second] = note.replace(/\.$/, "").split(/[:.;]\s/);
  return first.length < MIN_SUMMARY_LENGTH && second ? title(second.split(/, (?:with|as|and|denser|cyan)\b/)[0]) : first;
}
