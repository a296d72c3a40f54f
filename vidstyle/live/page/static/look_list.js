// The looks of a session as pictures, with a search.

import { get, make, press, title } from "./elements.js";
import { findLooks, offerWords } from "./find_looks.js";

/** @typedef {{name: string, note: string, kinds: string[], aliases: string, words: string}} Described */

/** Shows the looks, the one that runs first. */
export class LookList {
  #list = get("styles");
  #finder = /** @type {HTMLInputElement} */ (get("find-look"));
  /** @type {HTMLButtonElement[]} */
  #buttons = [];
  /** What the search knows of them, once it has arrived. @type {Map<string, Described>} */
  #described = new Map();
  /** @type {HTMLButtonElement | undefined} */
  #chosen;

  /** @param {(name: string) => void} onchoose */
  constructor(onchoose) {
    this.onchoose = onchoose;
    this.#finder.addEventListener("input", () => this.#find());
    this.#finder.addEventListener("keydown", (event) => this.#key(event));
    this.#list.addEventListener("scroll", () => this.#fade());
    addEventListener("resize", () => this.#show());
    get("all-looks").onclick = () => this.search("");
  }

  /** @param {string[]} names */
  show(names) {
    this.#buttons = names.map((name) => this.#button(name));
    this.#chosen = undefined;
    this.#find();
  }

  /** @param {Described[]} looks */
  describe(looks) {
    this.#described = new Map(looks.map((look) => [look.name, look]));
    this.#find();
  }

  /** Shows the looks that a text finds. @param {string} text */
  search(text) {
    this.#finder.value = text;
    this.#find();
    this.focus();
  }

  /** Moves the focus to the search. */
  focus() {
    this.#finder.focus();
  }

  /** Marks the look that runs. @param {string} name @param {string} full with its variant */
  choose(name, full) {
    // A session that was started with a variant lists it among the styles.
    const wanted = this.#buttons.some((button) => button.dataset.name === full) ? full : name;
    const chosen = this.#buttons.find((button) => button.dataset.name === wanted);
    for (const button of this.#buttons) press(button, button === chosen);
    if (!chosen || chosen === this.#chosen) return;
    if (!this.#chosen) this.#buttons = [chosen, ...this.#buttons.filter((button) => button !== chosen)];
    const isFirst = !this.#chosen;
    this.#chosen = chosen;
    if (isFirst) this.#find();
    else this.#show();
  }

  /** @param {string} name */
  #button(name) {
    const picture = make("img", { src: `thumbnail.jpg?of=${encodeURIComponent(name)}`, alt: "", width: 240, height: 135 });
    const made = make("button", { title: title(name), onclick: () => this.onchoose(name) }, picture, make("span", { textContent: title(name) }));
    made.dataset.name = name;
    return made;
  }

  #find() {
    const looks = this.#buttons.map(({ dataset: { name = "" } }) => {
      const { note = "", kinds = [], aliases = "", words = "" } = this.#described.get(name) ?? {};
      return { name: title(name), aliases, about: `${note} ${kinds.join(", ")}`, words };
    });
    const found = findLooks(looks, this.#finder.value).map((number) => this.#buttons[number]);
    const focused = document.activeElement;
    this.#list.replaceChildren(...found);
    if (focused instanceof HTMLElement && found.some((button) => button === focused)) focused.focus();
    get("no-look").hidden = found.length > 0 || !this.#buttons.length;
    if (!found.length) offerWords(looks, this.#finder.value, (word) => this.search(word));
    this.#show();
  }

  /** Enter chooses the best look and ends the search. @param {KeyboardEvent} event */
  #key(event) {
    const first = /** @type {HTMLElement | null} */ (this.#list.firstElementChild);
    if (event.key === "Enter" && first && this.#finder.value.trim()) {
      first.click();
      this.search("");
      first.focus();
    } else if (event.key === "ArrowDown") first?.focus();
    else if (event.key === "Escape") this.search("");
    else return;
    event.preventDefault();
  }

  /** Marks the edges behind which there are more looks. */
  #fade() {
    const { scrollTop, scrollHeight, clientHeight } = this.#list;
    this.#list.classList.toggle("more-above", scrollTop > 1);
    this.#list.classList.toggle("more-below", scrollTop + clientHeight < scrollHeight - 1);
  }

  /** Scrolls to the chosen look: the list only, and only as far as needed. */
  #show() {
    const [list, button] = [this.#list, this.#chosen];
    this.#fade();
    if (!button?.isConnected) return;
    const nearest = (/** @type {number} */ at, /** @type {number} */ begin, /** @type {number} */ size, /** @type {number} */ room) => Math.min(Math.max(at, begin + size - room), begin);
    const top = nearest(list.scrollTop, button.offsetTop, button.offsetHeight, list.clientHeight);
    const left = nearest(list.scrollLeft, button.offsetLeft, button.offsetWidth, list.clientWidth);
    list.scrollTo({ left, top, behavior: "smooth" });
  }
}
