// The search of looks, on all pages that list them.

/**
 * What a search knows of a look.
 * @typedef {object} Look
 * @property {string} name
 * @property {string} aliases other names, separated by commas, the most fitting first
 * @property {string} about its description and kinds
 * @property {string} words for its blocks and variants
 */

/** A shorter word among others, such as "a" or "the", begins a name only by chance. */
const MIN_BEGINNING_LENGTH = 4;
/** Better than this rank, a look has the name that was asked. */
const DESCRIBED = 5;
const NOT_FOUND = 7;

/** Whether a text has all words, or words that begin so. @param {string} text @param {string[]} words */
function hasAll(text, words) {
  const parts = text.toLowerCase().split(/[^\p{L}\p{N}]+/u);
  return words.every((word) => parts.some((part) => part.startsWith(word)) || (/[^\p{L}\p{N}]/u.test(word) && text.toLowerCase().includes(word)));
}

/** Returns how well a look fits: lower is better. @param {Look} look @param {string[]} words */
function rank({ name, aliases, about, words: more }, words) {
  const asked = words.join(" ");
  const own = name.toLowerCase();
  const others = aliases.toLowerCase().split(/,\s*/).filter(Boolean);
  if (own === asked) return 0;
  if (others.includes(asked)) return 1 + others.indexOf(asked) / others.length;
  if (own.startsWith(asked)) return 2;
  if (words.some((word) => own === word || (word.length >= MIN_BEGINNING_LENGTH && own.startsWith(word)))) return 3;
  if (others.some((other) => hasAll(other, words))) return 4;
  if (hasAll(`${name} ${about}`, words)) return DESCRIBED;
  return hasAll(more, words) ? DESCRIBED + 1 : NOT_FOUND;
}

/**
 * Returns the numbers of the looks that a text names, best first; those that it describes only if it names none.
 * @param {Look[]} looks
 * @param {string} text
 */
export function findLooks(looks, text) {
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  if (!words.length) return [...looks.keys()];
  const ranks = looks.map((look) => rank(look, words));
  const best = Math.min(...ranks);
  const limit = best < DESCRIBED ? DESCRIBED : best < NOT_FOUND ? Math.floor(best) + 1 : 0;
  return [...looks.keys()].filter((number) => ranks[number] < limit).sort((one, other) => ranks[one] - ranks[other]);
}
