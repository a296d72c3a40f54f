// An edited comic as files: its page file, and the page itself.

import { numbers } from "./bubble_shapes.js";

/** @typedef {import("./bubble_shapes.js").Bubble} Bubble */

const KEY = "[[page.panel.words]]";

/** A copy of the page from before all edits, in a document that is not displayed. */
const original = document.implementation.createHTMLDocument().importNode(document.documentElement, true);
const [head, ...entries] = JSON.parse(original.querySelector("#page-file")?.textContent || '""').split(KEY);

/** Whether words are drawn in capitals. */
export const inCapitals = /^font = "comic"$/m.test(head);

/** The words of each bubble, as in the page file. @type {string[]} */
export const allWords = entries.map((/** @type {string} */ text) => JSON.parse(/^text = (.*)$/m.exec(text)?.[1] ?? '""'));

/** Returns the edited page file; unchanged entries are copied byte for byte. @param {Bubble[]} bubbles */
export function editedFile(bubbles) {
  const texts = bubbles.map(({ number, words, firstWords, size, firstSize, place, first }) => {
    const rounded = place.map((side) => Math.round(side * 100) / 100).join(", ");
    const sized = size === firstSize ? entries[number] : entries[number].replace(/^size = .*$/m, `size = ${size}`);
    const text = words === firstWords ? sized : sized.replace(/^text = .*$/m, () => `text = ${JSON.stringify(words)}`);
    return place === first ? text : text.replace(/^place = .*$/m, `place = [${rounded}]`);
  });
  return [head, ...texts].join(KEY);
}

/** Returns the edited page, which can be edited further. @param {Bubble[]} bubbles */
export function editedPage(bubbles) {
  const groups = /** @type {NodeListOf<SVGGElement>} */ (original.querySelectorAll("g[data-place]"));
  for (const { group, number, place, first, words, firstWords } of bubbles) {
    if (place === first && words === firstWords && numbers(groups[number].dataset.place)?.join() === first.join()) continue;
    groups[number].dataset.place = place.join(" ");
    for (const kind of ["polygon", "text"]) {
      const now = group.querySelectorAll(kind);
      groups[number].querySelectorAll(kind).forEach((each, at) => each.replaceWith(now[at].cloneNode(true)));
    }
  }
  // JSON in a page must not contain the end tag of its element.
  const data = JSON.stringify(editedFile(bubbles)).replaceAll("<", "\\u003c");
  /** @type {HTMLElement} */ (original.querySelector("#page-file")).textContent = data;
  return `<!doctype html>\n${original.outerHTML}`;
}
