// The search of looks, on all pages that list them.

import { get, make } from "./elements.js";

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
/** Words are near if they share this part of their pairs of letters. */
const MIN_LIKENESS_RATIO = 0.5;
const MAX_WORDS_TO_TRY = 4;

/** Returns a text in lower case, in the American spelling and without hyphens. @param {string} text */
const normal = (text) => text.toLowerCase().replaceAll("colour", "color").replaceAll("grey", "gray").replaceAll("&", "and").replaceAll("-", " ");

/** Returns a text without spaces: "game boy" and "gameboy" are the same. @param {string} text */
const joined = (text) => text.replaceAll(" ", "");

/** Returns the other names of a look. @param {string} aliases */
const aliasesOf = (aliases) => aliases.split(/,\s*/).filter(Boolean);

/** Whether a text has all words, or words that begin so. @param {string} text @param {string[]} words */
function hasAll(text, words) {
  const parts = text.split(/[^\p{L}\p{N}]+/u);
  return words.every((word) => parts.some((part) => part.startsWith(word)) || (/[^\p{L}\p{N}]/u.test(word) && text.includes(word)));
}

/** Returns where in a text the first word stands: 0 at its beginning, less than 1. @param {string} text @param {string[]} words */
const placeIn = (text, words) => Math.max(text.indexOf(words[0]), 0) / (text.length + 1);

/** Returns how well a look fits: lower is better. @param {Look} look @param {string[]} words */
function rank(look, words) {
  const asked = words.join(" ");
  const [own, about, more] = [look.name, look.about, look.words].map(normal);
  const others = aliasesOf(normal(look.aliases));
  if (own === asked) return 0;
  const named = others.findIndex((other) => joined(other) === joined(asked));
  if (named >= 0) return 1 + named / others.length;
  if (own.startsWith(asked)) return 2;
  if (words.some((word) => own === word || (word.length >= MIN_BEGINNING_LENGTH && own.startsWith(word)))) return 3;
  const at = others.findIndex((other) => hasAll(other, words));
  if (at >= 0) return 4 + at / others.length;
  if (hasAll(`${own} ${about}`, words)) return DESCRIBED + placeIn(about, words);
  return hasAll(more, words) ? DESCRIBED + 1 + placeIn(more, words) : NOT_FOUND;
}

/**
 * Returns the numbers of the looks that a text names, best first; those that it describes only if it names none,
 * and those that one of its longer words names only if it describes none.
 * @param {Look[]} looks
 * @param {string} text
 */
export function findLooks(looks, text) {
  const words = normal(text).split(/\s+/).filter(Boolean);
  if (!words.length) return [...looks.keys()];
  const ranks = ranksOf(looks, words);
  if (words.length === 1 || Math.min(...ranks) < NOT_FOUND) return bestOf(ranks);
  const single = words.filter((word) => word.length > MIN_BEGINNING_LENGTH).map((word) => ranksOf(looks, [word]));
  return bestOf(looks.map((_, number) => Math.min(NOT_FOUND, ...single.map((each) => each[number]))));
}

/** @param {Look[]} looks @param {string[]} words */
const ranksOf = (looks, words) => looks.map((look) => rank(look, words));

/** Returns the numbers of the looks with the best kind of rank, best first. @param {number[]} ranks */
function bestOf(ranks) {
  const best = Math.min(...ranks);
  const limit = best < DESCRIBED ? DESCRIBED : best < NOT_FOUND ? Math.floor(best) + 1 : 0;
  return [...ranks.keys()].filter((number) => ranks[number] < limit).sort((one, other) => ranks[one] - ranks[other]);
}

/** Returns the pairs of letters of a text. @param {string} text */
const pairsOf = (text) => new Set([...text.slice(1)].map((letter, place) => text[place] + letter));

/** Returns which part of their pairs of letters two texts share, 0 to 1. @param {string} one @param {string} other */
function likeness(one, other) {
  const [pairs, others] = [pairsOf(normal(one)), pairsOf(normal(other))];
  return (2 * [...pairs].filter((pair) => others.has(pair)).length) / (pairs.size + others.size || 1);
}

/**
 * Returns words that find looks where a text finds none: the nearest names, or else those that most looks share.
 * @param {Look[]} looks
 * @param {string} text
 */
function wordsToTry(looks, text) {
  const names = looks.flatMap(({ name, aliases }) => [name, ...aliasesOf(aliases)]);
  const count = (/** @type {string} */ word) => names.filter((name) => name === word).length;
  const all = [...new Set(names)];
  const near = all.filter((word) => likeness(word, text) >= MIN_LIKENESS_RATIO).sort((one, other) => likeness(other, text) - likeness(one, text));
  return (near.length ? near : all.sort((one, other) => count(other) - count(one))).slice(0, MAX_WORDS_TO_TRY);
}

/**
 * Offers words in place of an empty list; words of looks of another kind come first.
 * @param {Look[]} looks
 * @param {string} text
 * @param {(word: string) => void} choose searches for one of them
 */
export function offerWords(looks, text, choose) {
  const found = text.trim() ? findLooks(looks, text).map((number) => looks[number].name) : [];
  const offered = found.length ? found.slice(0, MAX_WORDS_TO_TRY) : wordsToTry(looks, text);
  get("words-to-try").replaceChildren(...offered.map((word) => make("button", { type: "button", textContent: word, onclick: () => choose(word) })));
}
