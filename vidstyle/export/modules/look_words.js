// Words of a search of looks: their spelling, stems and typing errors.

/** Words that say nothing about a look, unless they are all that is asked. */
const FILLER_WORDS = new Set(
  "a an and as at be by can effect effects filter filters for from give i in is it its kind like look looking looks made make makes me more my of on one or please preset something sort style styled styles that the theme this to turn type very want with".split(" "),
);
/** British spellings, and other signs for a word. */
const SPELLINGS = [[/colour/g, "color"], [/grey/g, "gray"], [/centre/g, "center"], [/theatre/g, "theater"], [/mould/g, "mold"], [/is(?=(?:e[ds]?|ing|ation)\b)/g, "iz"], [/&/g, " and "], [/['’.]/g, ""]];
/** Endings that a search ignores. */
const WORD_ENDING = /(?:ness|istic|ists?|ism|ings?|ish|ies?|y|ed|es|(?<!s)s|e)$/;
/** Endings that a search ignores if the word is not known with them. */
const COMPARING_ENDING = /(?:like|erly|ier|iest|er|est|ly)$/;
const MIN_STEM_LENGTH = 3;
/** From this length on, a word may have one typing error; what it means may be shorter by one letter. */
const MIN_TYPO_LENGTH = 5;

/** Returns a word without its ending: "painted" and "painting" are the same. @param {string} word */
export function stemOf(word) {
  const stem = word.replace(WORD_ENDING, "");
  if (stem === word || stem.length < MIN_STEM_LENGTH || !/[aeiouy]/.test(stem)) return word;
  return stem.replace(/([bdgmnpt])\1$/, (pair) => pair[0]);
}

/** Returns the stem of a compared word, such as "darker" or "painterly". @param {string} word */
const comparedStem = (word) => stemOf(word.replace(COMPARING_ENDING, ""));

/** Returns the words of a text that say something about a look, in the American spelling. @param {string} text */
export function tellingWords(text) {
  let plain = text.toLowerCase().normalize("NFD").replace(/\p{M}/gu, "");
  for (const [spelling, same] of SPELLINGS) plain = plain.replace(spelling, /** @type {string} */ (same));
  const words = plain.split(/[^\p{L}\p{N}]+/u).filter(Boolean);
  const telling = words.filter((word) => !FILLER_WORDS.has(word));
  return telling.length ? telling : words;
}

/** Whether a word is another with one letter missing, added, wrong, or swapped with the next. @param {string} word @param {string} other */
function isTypo(word, other) {
  let same = 0;
  while (same < word.length && word[same] === other[same]) same++;
  const [rest, wanted] = [word.slice(same), other.slice(same)];
  if (rest.slice(1) === wanted.slice(1) || rest.slice(1) === wanted || rest === wanted.slice(1)) return true;
  return rest[0] === wanted[1] && rest[1] === wanted[0] && rest.slice(2) === wanted.slice(2);
}

/**
 * Returns the stems in a vocabulary that a word means: its own stem, stems of words with this beginning, or stems at a distance of one typing error.
 * @param {string} word
 * @param {Map<string, string>} vocabulary words and their stems
 * @param {Set<string>} stems of the vocabulary
 */
function meantStems(word, vocabulary, stems) {
  const own = [stemOf(word), comparedStem(word)].find((stem) => stems.has(stem));
  if (own) return [own];
  const meant = (/** @type {(known: string) => boolean} */ fits) => [...vocabulary].filter(([known]) => fits(known)).map(([, stem]) => stem);
  const begun = word.length < MIN_STEM_LENGTH ? [] : meant((known) => known.startsWith(word));
  return begun.length || word.length < MIN_TYPO_LENGTH ? begun : meant((known) => known.length >= MIN_TYPO_LENGTH - 1 && isTypo(word, known));
}

/**
 * Returns the stems that each word of a text means in a vocabulary; two words may be one there ("game boy").
 * @param {string} text
 * @param {Map<string, string>} vocabulary words and their stems
 */
export function meaningsOf(text, vocabulary) {
  const words = tellingWords(text), stems = new Set(vocabulary.values()), meanings = [];
  for (let at = 0; at < words.length; at++) {
    const pair = at + 1 < words.length ? stemOf(words[at] + words[at + 1]) : "";
    meanings.push(stems.has(pair) ? [pair] : meantStems(words[at], vocabulary, stems));
    if (stems.has(pair)) at++;
  }
  return meanings;
}
