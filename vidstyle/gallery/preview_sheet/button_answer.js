// Buttons that confirm an action.

/** For this time a button shows what it has done. */
const ANSWER_MS = 4000;
/** The usual words of the buttons that show an answer. @type {Map<HTMLElement, string>} */
const usualWords = new Map();

/** Shows an answer in place of the words of a button, for a moment. @param {HTMLElement} words the button or a part of it @param {string} text */
export function answer(words, text) {
  const button = /** @type {HTMLElement} */ (words.closest("button"));
  button.style.minWidth = `${button.getBoundingClientRect().width}px`; // nothing next to it moves
  if (!usualWords.has(words)) usualWords.set(words, String(words.textContent));
  words.textContent = text;
  setTimeout(() => withdraw(words), ANSWER_MS);
}

/** Shows the usual words again: the button now belongs to something else. @param {HTMLElement} words */
export function withdraw(words) {
  const usual = usualWords.get(words);
  if (usual !== undefined) words.textContent = usual;
  usualWords.delete(words);
}
