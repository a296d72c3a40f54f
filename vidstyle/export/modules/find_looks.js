// The search of looks, on all pages that list them.

import { get, make } from "./elements.js";
import { ABSENT_LOOKS, LOOK_PROPERTIES } from "./look_properties.js";
import { meaningsOf, stemOf, tellingWords } from "./look_words.js";

/**
 * What a search knows of a look.
 * @typedef {object} Look
 * @property {string} name
 * @property {string} aliases other names, separated by commas, the most fitting first
 * @property {string} about its description and kinds
 * @property {string} words for its blocks and variants
 */

/** A name of a look, its words with their stems, and how much it says. @typedef {{words: string[], stems: string[], weight: number}} LookName */

const NAME_WEIGHT = 3;
const ALIAS_WEIGHT = 1;
const ABOUT_WEIGHT = 0.2;
const BLOCKS_WEIGHT = 0.1;
/** Part of the weight that the last of a list of names lacks. */
const LAST_LOSS_RATIO = 0.3;
/** Looks that fit less than this part of the best are not shown. */
const MIN_SCORE_RATIO = 0.5;
/** Words are near if they share this part of their pairs of letters. */
const MIN_LIKENESS_RATIO = 0.6;
const MAX_WORDS_TO_TRY = 4;
/** Related looks follow up to this number of results. */
const MAX_FEW = 3;
const MAX_RELATED = 5;
/** Looks that are nearer than this to a text and its best result are related: four shared properties, or a telling word; if there are none, three. */
const MIN_RELATED_NEARNESS = [0.4, 0.29];
/** Weight of a property that a look shares with the best result. */
const SHARED_WEIGHT = 0.1;

/** Returns the names in a text. @param {string} aliases */
const aliasesOf = (aliases) => aliases.split(/,\s*/).filter(Boolean);

/** @param {string[]} words @param {number} weight @returns {LookName} */
const lookName = (words, weight) => ({ words, stems: words.map(stemOf), weight });

/** Returns a name in its words and in one word: "game boy" and "gameboy". @param {string} text @param {number} weight */
function spelledNames(text, weight) {
  const words = tellingWords(text);
  return [words, ...(words.length > 1 ? [[words.join("")]] : [])].map((each) => lookName(each, weight));
}

/** Returns weighted names of a list, the most fitting first. @param {string[]} names */
const listedNames = (names) => names.flatMap((name, place) => spelledNames(name, ALIAS_WEIGHT * (1 - (LAST_LOSS_RATIO * place) / names.length)));

/** Returns the properties of a look, as names. @param {string} look */
function propertiesOf(look) {
  return Object.entries(LOOK_PROPERTIES).flatMap(([words, having]) => {
    const looks = having.split(" "), place = looks.indexOf(tellingWords(look).join(" "));
    return place < 0 ? [] : aliasesOf(words).flatMap((word) => spelledNames(word, ALIAS_WEIGHT * (1 - (LAST_LOSS_RATIO * place) / looks.length)));
  });
}

/**
 * Returns a function that keeps its results: pages describe the same looks again for each search.
 * @template T
 * @param {(look: Look) => T} compute
 */
function remembered(compute) {
  const results = /** @type {Map<string, T>} */ (new Map());
  return (/** @type {Look} */ look) => {
    const key = [look.name, look.aliases, look.about, look.words].join("\n");
    const result = results.get(key) ?? compute(look);
    results.set(key, result);
    return result;
  };
}

/** Returns all names of a look. */
const namesOf = remembered(({ name, aliases }) => [...spelledNames(name, NAME_WEIGHT), ...listedNames(aliasesOf(aliases)), ...propertiesOf(name)]);

/** Returns the words that describe a look, each for itself. */
const descriptionsOf = remembered(({ about, words }) => {
  const each = (/** @type {string} */ text, /** @type {number} */ weight) => tellingWords(text).map((word) => lookName([word], weight));
  return [...each(about, ABOUT_WEIGHT), ...each(words, BLOCKS_WEIGHT)];
});

/** Returns how well names fit a meaning, given what else is asked: names with further words fit less. @param {LookName[]} names @param {string[]} meaning @param {Set<string>} asked */
function fitOf(names, meaning, asked) {
  const fitting = names.filter(({ stems }) => stems.some((stem) => meaning.includes(stem)));
  return Math.max(0, ...fitting.map(({ stems, weight }) => (weight * stems.filter((stem) => asked.has(stem)).length) / stems.length));
}

/** Returns what the words of a text mean among names. @param {LookName[][]} names of each look @param {string} text */
const meaningsIn = (names, text) => meaningsOf(text, new Map(names.flat().flatMap(({ words, stems }) => words.map((word, place) => [word, stems[place]]))));

/** Returns the scores of looks: a word counts the more, the fewer looks have it. @param {LookName[][]} names of each look @param {string} text */
function scoresOf(names, text) {
  const meanings = meaningsIn(names, text);
  const asked = new Set(meanings.flat());
  const scores = names.map(() => 0);
  for (const meaning of meanings) {
    const fits = names.map((each) => fitOf(each, meaning, asked));
    const rarity = Math.log(1 + names.length / fits.filter(Boolean).length);
    fits.forEach((fit, look) => (scores[look] += fit && fit * rarity));
  }
  return scores;
}

/** Returns the stems of a text in one order, whatever the order of its words. @param {string} text */
const stemsOf = (text) => tellingWords(text).map(stemOf).sort().join(" ");

/** Returns the names in the style file of a look, in their stems. */
const ownStems = remembered(({ name, aliases }) => new Set([name, ...aliasesOf(aliases)].map(stemsOf)));

/** Returns a name in one spelling, with all its words. @param {string} text */
const tellingName = (text) => text.trim().toLowerCase().replace(/[-_\s]+/g, " ");

/** Returns what comes closest to a text that names what no look is: names of looks, and what else to say. @param {Look[]} looks @param {string} text */
function absentOf(looks, text) {
  const found = Object.entries(ABSENT_LOOKS).find(([words]) => aliasesOf(words).map(stemsOf).includes(stemsOf(text)));
  if (!found || looks.some((look) => ownStems(look).has(stemsOf(text)))) return null;
  const [names, note = "These come closest."] = found[1].split(" | ");
  return { names: names.split(" "), note };
}

/** Returns the numbers of looks with these names, which have the spelling of the properties. @param {Look[]} looks @param {string[]} names */
const numbersOf = (looks, names) => names.map((name) => looks.findIndex((look) => tellingWords(look.name).join(" ") === name)).filter((look) => look >= 0);

/** Returns what to say of the looks that a text finds: "" if they are what it asks for. @param {Look[]} looks @param {string} text @param {number} best */
function nearNote(looks, text, best) {
  const names = looks.map((look) => [...namesOf(look), ...descriptionsOf(look)]);
  const meanings = meaningsIn(names, text), asked = new Set(meanings.flat());
  const isAll = meanings.every((meaning) => fitOf(names[best], meaning, asked) > 0);
  const absent = absentOf(looks, text);
  return isAll && !absent ? "" : `No look is exactly “${text.trim()}”. ${absent?.note ?? "These come closest."}`;
}

/**
 * Returns the numbers of the looks that a text means, best first: those with this very name lead, and descriptions count
 * only for a text that names none.
 * @param {Look[]} looks
 * @param {string} text
 */
export function findLooks(looks, text) {
  if (!tellingWords(text).length) return [...looks.keys()];
  const near = numbersOf(looks, absentOf(looks, text)?.names ?? []);
  if (near.length) return near;
  const named = scoresOf(looks.map(namesOf), text);
  const scores = Math.max(...named) > 0 ? named : scoresOf(looks.map(descriptionsOf), text);
  const least = Math.max(...scores) * MIN_SCORE_RATIO;
  const isExact = looks.map((look) => ownStems(look).has(stemsOf(text)));
  const found = [...looks.keys()].filter((look) => isExact[look] || (least > 0 && scores[look] >= least));
  const isNamed = looks.map(({ name }) => tellingName(name) === tellingName(text));
  return found.sort((one, other) => Number(isNamed[other]) - Number(isNamed[one]) || Number(isExact[other]) - Number(isExact[one]) || scores[other] - scores[one]);
}

/** Returns the number of properties that two looks share. @param {Look} one @param {Look} other */
function sharedProperties(one, other) {
  const [name, otherName] = [one, other].map((look) => tellingWords(look.name).join(" "));
  return Object.values(LOOK_PROPERTIES).filter((having) => [name, otherName].every((each) => having.split(" ").includes(each))).length;
}

/**
 * Returns the numbers of looks next to the few that a text finds, best first: those that a word of it describes, then
 * those with most properties of the best. None are related to what is itself only near.
 * @param {Look[]} looks
 * @param {string} text
 */
export function relatedLooks(looks, text) {
  const found = findLooks(looks, text);
  if (!found.length || found.length > MAX_FEW || absentOf(looks, text)) return [];
  const scores = scoresOf(looks.map((look) => [...namesOf(look), ...descriptionsOf(look)]), text);
  const nearness = looks.map((look, number) => scores[number] + SHARED_WEIGHT * sharedProperties(looks[found[0]], look));
  const others = [...looks.keys()].filter((look) => !found.includes(look));
  const related = MIN_RELATED_NEARNESS.map((least) => others.filter((look) => nearness[look] >= least)).find((near) => near.length) ?? [];
  return related.sort((one, other) => nearness[other] - nearness[one]).slice(0, MAX_RELATED);
}

/** Returns the pairs of letters of a text. @param {string} text */
const pairsOf = (text) => new Set([...text.slice(1)].map((letter, place) => text[place] + letter));

/** Returns which part of their pairs of letters two texts share, 0 to 1. @param {string} one @param {string} other */
function likeness(one, other) {
  const [pairs, others] = [one, other].map((text) => pairsOf(text.toLowerCase()));
  return (2 * [...pairs].filter((pair) => others.has(pair)).length) / (pairs.size + others.size || 1);
}

/**
 * Returns names of looks that are near to a text that finds none, or to one of its words.
 * @param {Look[]} looks
 * @param {string} text
 */
function wordsToTry(looks, text) {
  const names = [...new Set(looks.flatMap(({ name, aliases }) => [name, ...aliasesOf(aliases)]))];
  const nearness = (/** @type {string} */ name) => Math.max(likeness(name, text), ...text.split(" ").map((word) => likeness(name, word)));
  const near = names.filter((name) => nearness(name) >= MIN_LIKENESS_RATIO);
  return near.sort((one, other) => nearness(other) - nearness(one)).slice(0, MAX_WORDS_TO_TRY);
}

/** Offers words in place of an empty list; looks of another kind come first. @param {Look[]} looks @param {string} text @param {(word: string) => void} choose */
function offerWords(looks, text, choose) {
  const found = text.trim() ? findLooks(looks, text).map((number) => looks[number].name) : [];
  const offered = found.length ? found.slice(0, MAX_WORDS_TO_TRY) : wordsToTry(looks, text);
  const buttons = offered.map((word) => make("button", { type: "button", textContent: word, onclick: () => choose(word) }));
  get("words-to-try").replaceChildren(...(offered.length ? ["Try ", ...buttons] : []));
}

/**
 * Says what a search finds, next to its results: that it is only near, or, of an empty list, which words to try.
 * @param {Look[]} looks
 * @param {string} text
 * @param {boolean} isEmpty whether no look is shown, such as of the chosen kind
 * @param {(word: string) => void} choose searches for a word
 */
export function describeSearch(looks, text, isEmpty, choose) {
  const [best] = findLooks(looks, text);
  get("near-look").textContent = isEmpty || best === undefined || !tellingWords(text).length ? "" : nearNote(looks, text, best);
  get("no-look").hidden = !isEmpty;
  if (isEmpty) offerWords(looks, text, choose);
}

// A phone has no key for the search.
const phone = matchMedia("(max-width: 44rem), (hover: none)");
const nameKey = () => document.getElementById("find-look")?.setAttribute("placeholder", phone.matches ? "Find a look" : "Find a look ( / )");
phone.addEventListener("change", nameKey);
nameKey();
