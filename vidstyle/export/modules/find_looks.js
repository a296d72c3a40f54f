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
/** Words that say nothing about a look, unless they are all that is asked. */
const FILLERS = new Set("a an and as by effect filter for from in like look looks my of on style the to with".split(" "));
/** A word is an ending from this length on: "crayons" asks for crayon, but "dots" is no dot. */
const MIN_PLURAL_LENGTH = 5;
/** Words are near if they share this part of their pairs of letters. */
const MIN_LIKENESS_RATIO = 0.6;
const MAX_WORDS_TO_TRY = 4;

/** Returns a text in lower case, in the American spelling and without hyphens. @param {string} text */
const normal = (text) => text.toLowerCase().replaceAll("colour", "color").replaceAll("grey", "gray").replaceAll("&", "and").replaceAll("-", " ");

/** Returns a text without spaces: "game boy" and "gameboy" are the same. @param {string} text */
const joined = (text) => text.replaceAll(" ", "");

/** Returns a word without the ending of a plural. @param {string} word */
const singular = (word) => (word.length >= MIN_PLURAL_LENGTH && word.endsWith("s") && !word.endsWith("ss") ? word.slice(0, -1) : word);

/** Returns the words of a text that say something about a look. @param {string} text */
function askedWords(text) {
  const words = normal(text).split(/\s+/).filter(Boolean);
  const telling = words.filter((word) => !FILLERS.has(word));
  return telling.length ? telling : words;
}

/** Returns the other names of a look. @param {string} aliases */
const aliasesOf = (aliases) => aliases.split(/,\s*/).filter(Boolean);

/** Whether a text has all words, or words that begin so. @param {string} text @param {string[]} words */
function hasAll(text, words) {
  const parts = text.split(/[^\p{L}\p{N}]+/u);
  return words.every((word) => parts.some((part) => part.startsWith(word)) || (/[^\p{L}\p{N}]/u.test(word) && text.includes(word)));
}

/** Whether a name has one of these words. @param {string} name @param {string[]} words */
const hasAny = (name, words) => words.some((word) => hasAll(name, [word]));

/** Returns where in a text the first word stands: 0 at its beginning, less than 1. @param {string} text @param {string[]} words */
const placeIn = (text, words) => Math.max(text.indexOf(words[0]), 0) / (text.length + 1);

/** Returns how well a look fits: lower is better. @param {Look} look @param {string} phrase the whole text @param {string[]} words */
function rank(look, phrase, words) {
  const stems = words.map(singular), asked = stems.join(" ");
  const [own, about, more] = [look.name, look.about, look.words].map(normal);
  const others = aliasesOf(normal(look.aliases));
  const same = (/** @type {string} */ name) => [phrase, words.join(" "), asked].some((each) => joined(each) === joined(name)) || (singular(name) === asked && asked !== "");
  if (same(own)) return 0;
  const named = others.findIndex(same);
  if (named >= 0) return 1 + named / others.length;
  if (own.startsWith(asked)) return 2;
  if (stems.some((word) => own === word || (word.length >= MIN_BEGINNING_LENGTH && own.startsWith(word)))) return 3;
  const at = others.findIndex((other) => hasAll(other, stems));
  if (at >= 0) return 4 + (0.5 * at) / others.length;
  const mixed = others.findIndex((other) => hasAny(other, stems));
  if (mixed >= 0 && hasAll(`${own} ${others.join(" ")} ${about}`, stems)) return 4.5 + (0.5 * mixed) / others.length;
  if (hasAll(`${own} ${about}`, stems)) return DESCRIBED + placeIn(about, stems);
  return hasAll(more, stems) ? DESCRIBED + 1 + placeIn(more, stems) : NOT_FOUND;
}

/**
 * Returns the numbers of the looks that a text names, best first; those that it describes only if it names none,
 * and those that fit most of its words only if none fits all of them.
 * @param {Look[]} looks
 * @param {string} text
 */
export function findLooks(looks, text) {
  const words = askedWords(text);
  if (!words.length) return [...looks.keys()];
  const ranks = ranksOf(looks, normal(text).trim(), words);
  if (words.length === 1 || Math.min(...ranks) < NOT_FOUND) return bestOf(ranks);
  const long = words.filter((word) => word.length > MIN_BEGINNING_LENGTH);
  return bestOf(byMostWords(long.map((word) => ranksOf(looks, word, [word]))));
}

/** Returns the ranks of looks that fit most words, by their best word. @param {number[][]} ranks of each word */
function byMostWords(ranks) {
  const looks = [...(ranks[0] ?? []).keys()];
  const fitting = looks.map((look) => ranks.filter((each) => each[look] < NOT_FOUND).length);
  const most = Math.max(...fitting);
  return looks.map((look) => (most && fitting[look] === most ? Math.min(...ranks.map((each) => each[look])) : NOT_FOUND));
}

/** @param {Look[]} looks @param {string} phrase @param {string[]} words */
const ranksOf = (looks, phrase, words) => looks.map((look) => rank(look, phrase, words));

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
 * Returns names of looks that are near to a text that finds none, or to one of its words.
 * @param {Look[]} looks
 * @param {string} text
 */
function wordsToTry(looks, text) {
  const names = [...new Set(looks.flatMap(({ name, aliases }) => [name, ...aliasesOf(aliases)]))];
  const nearness = (/** @type {string} */ name) => Math.max(likeness(name, text), ...askedWords(text).map((word) => likeness(name, word)));
  const near = names.filter((name) => nearness(name) >= MIN_LIKENESS_RATIO);
  return near.sort((one, other) => nearness(other) - nearness(one)).slice(0, MAX_WORDS_TO_TRY);
}

/**
 * Offers words in place of an empty list; looks of another kind come first.
 * @param {Look[]} looks
 * @param {string} text
 * @param {(word: string) => void} choose searches for one of them
 */
export function offerWords(looks, text, choose) {
  const found = text.trim() ? findLooks(looks, text).map((number) => looks[number].name) : [];
  const offered = found.length ? found.slice(0, MAX_WORDS_TO_TRY) : wordsToTry(looks, text);
  const buttons = offered.map((word) => make("button", { type: "button", textContent: word, onclick: () => choose(word) }));
  get("words-to-try").replaceChildren(...(offered.length ? ["Try ", ...buttons] : []));
}
