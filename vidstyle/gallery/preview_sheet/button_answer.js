// Buttons that confirm an action.

/** For this time a button shows what it has done. */
const ANSWER_MS = 4000;

/** Shows an answer in place of the words of a button, for a moment. @param {HTMLElement} words the button or a part of it @param {string} text @param {string} usual */
export function answer(words, text, usual) {
  const button = /** @type {HTMLElement} */ (words.closest("button"));
  button.style.minWidth = `${button.offsetWidth}px`; // nothing next to it moves
  words.textContent = text;
  setTimeout(() => (words.textContent = usual), ANSWER_MS);
}
