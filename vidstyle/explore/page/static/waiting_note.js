// What the user waits for, and for how long so far.

import { make } from "./elements.js";

/** Shorter waits are not counted. */
const MIN_SECONDS = 3;

/** Shows in an element what is awaited, with the seconds since. */
export class WaitingNote {
  /** @type {ReturnType<typeof setInterval> | undefined} */
  #counting;

  /** @param {HTMLElement} element */
  constructor(element) {
    this.element = element;
  }

  /** Begins to wait, or continues with another text. @param {string} text */
  begin(text) {
    this.end(text);
    const count = make("span", { ariaHidden: "true" }); // screen readers would read each second
    this.element.append(count);
    const since = performance.now();
    this.#counting = setInterval(() => {
      const seconds = Math.floor((performance.now() - since) / 1000);
      if (seconds >= MIN_SECONDS) count.textContent = ` ${seconds} s`;
    }, 1000);
  }

  /** Ends the wait. @param {string} text the result, in words */
  end(text) {
    clearInterval(this.#counting);
    this.element.textContent = text;
  }
}
