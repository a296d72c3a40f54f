// The looks of a session as pictures, with a search.

import { get, make, press, title } from "./elements.js";
import { describeSearch, findLooks } from "./find_looks.js";

/** @typedef {{name: string, note: string, kinds: string[], aliases: string, words: string}} Described */

/** Number of looks that are listed unless all are wanted: two rows. */
const MAX_LISTED = 6;
/** The style that changes nothing; it is no look. */
const PLAIN = "plain";
/** The name of the unchanged picture. */
const SOURCE = "source";
/** For this time after the start, the computer is busy with the first frames. */
const SETTLE_MS = 3000;

/** Returns the words of the button that lists all looks. @param {HTMLButtonElement[]} buttons */
function labelOf(buttons) {
  const looks = buttons.filter(({ dataset }) => dataset.name !== PLAIN).length;
  return `All ${looks} looks${looks < buttons.length ? ` and ${title(PLAIN)}` : ""}`;
}

/** Shows the looks in their order; the one that runs is always listed. */
export class LookList {
  #list = get("styles");
  #finder = /** @type {HTMLInputElement} */ (get("find-look"));
  /** @type {HTMLButtonElement[]} */
  #buttons = [];
  /** What the search knows of them, once it has arrived. @type {Map<string, Described>} */
  #described = new Map();
  #isExpanded = false;
  /** Notices the looks that are in view. @type {IntersectionObserver} */
  #seen;
  /** Looks in view that are not drawn on the own picture. @type {Set<HTMLButtonElement>} */
  #waiting = new Set();
  /** Looks on the own picture, or on the photograph of vidstyle if they cannot be drawn; all are shown at once. @type {Map<HTMLButtonElement, HTMLImageElement>} */
  #own = new Map();
  #isOwn = false;
  #isTaking = false;
  /** @type {HTMLButtonElement | undefined} */
  #chosen;

  /** @param {(name: string) => void} onchoose */
  constructor(onchoose) {
    this.onchoose = onchoose;
    if (matchMedia("(hover: hover)").matches) this.#finder.placeholder += " ( / )"; // a key
    this.#finder.addEventListener("input", () => this.#findFirst());
    this.#finder.addEventListener("keydown", (event) => this.#key(event));
    get("all-looks").onclick = () => this.search("");
    get("more").onclick = () => this.#expand(!this.#isExpanded);
    this.#seen = new IntersectionObserver((entries) => this.#take(entries));
  }

  /** @param {string[]} names */
  show(names) {
    this.#buttons = names.map((name) => this.#button(name));
    this.#chosen = undefined;
    this.#isOwn = false;
    get("shown-on").textContent = "on an example";
    this.#find();
    setTimeout(() => this.#buttons.forEach((button) => this.#seen.observe(button)), SETTLE_MS);
  }

  /** Shows looks that are in view on the own picture, one after the other. @param {IntersectionObserverEntry[]} entries */
  async #take(entries) {
    for (const { target, isIntersecting } of entries) this.#waiting[isIntersecting ? "add" : "delete"](/** @type {HTMLButtonElement} */ (target));
    if (this.#isTaking) return;
    this.#isTaking = true;
    const source = this.#picture("look.jpg", SOURCE);
    const hasSource = await source.decode().then(() => true, () => false);
    for (const button of this.#waiting) {
      this.#seen.unobserve(button);
      this.#waiting.delete(button);
      const own = this.#picture("look.jpg", button.dataset.name ?? "");
      const isDrawn = await own.decode().then(() => true, () => false);
      this.#own.set(button, isDrawn ? own : this.#picture("thumbnail.jpg", button.dataset.name ?? ""));
      if (this.#isOwn) this.#showOwn(button, source);
    }
    this.#isTaking = false;
    if (this.#isOwn || !hasSource) return;
    this.#isOwn = true;
    get("shown-on").textContent = "on your picture";
    for (const button of this.#buttons) this.#showOwn(button, source);
  }

  /** Shows a look on the own picture: until it is drawn, the picture itself. @param {HTMLButtonElement} button @param {HTMLImageElement} source */
  #showOwn(button, source) {
    const waiting = /** @type {HTMLImageElement} */ (source.cloneNode());
    waiting.className = "waiting";
    button.querySelector("img")?.replaceWith(this.#own.get(button) ?? waiting);
  }

  /** Lists all looks, or the first ones. @param {boolean} on */
  #expand(on) {
    this.#isExpanded = on;
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
    this.#findFirst();
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
    this.#chosen = chosen;
    this.#find();
  }

  /** Returns the picture of a look on the photograph of vidstyle or on the own picture. @param {"thumbnail.jpg" | "look.jpg"} file @param {string} name */
  #picture(file, name) {
    return make("img", { src: `${file}?of=${encodeURIComponent(name)}`, alt: "", width: 240, height: 135 });
  }

  /** @param {string} name */
  #button(name) {
    const made = make("button", { title: title(name), onclick: ({ detail }) => this.#request(made, !detail) }, this.#picture("thumbnail.jpg", name), make("span", { textContent: title(name) }));
    made.dataset.name = name;
    return made;
  }

  /** Requests a look; by keyboard, that ends the search. @param {HTMLButtonElement} button @param {boolean} isByKeyboard */
  #request(button, isByKeyboard) {
    this.onchoose(button.dataset.name ?? "");
    if (!isByKeyboard || !this.#finder.value.trim()) return;
    press(button, true); // it is listed at once
    this.search("");
    button.focus();
  }

  #find() {
    const looks = this.#buttons.map(({ dataset: { name = "" } }) => {
      const { note = "", kinds = [], aliases = "", words = "" } = this.#described.get(name) ?? {};
      return { name: title(name), aliases, about: `${note} ${kinds.join(", ")}`, words };
    });
    const found = findLooks(looks, this.#finder.value).map((number) => this.#buttons[number]);
    const focused = document.activeElement;
    found.forEach((button, number) => button.classList.toggle("further", number >= MAX_LISTED));
    this.#list.replaceChildren(...found);
    this.#list.classList.toggle("all", this.#isExpanded || Boolean(this.#finder.value.trim()));
    this.#list.classList.toggle("expanded", this.#isExpanded);
    get("more").hidden = found.length <= MAX_LISTED || Boolean(this.#finder.value.trim());
    get("more").ariaExpanded = String(this.#isExpanded);
    get("more").textContent = this.#isExpanded ? "Fewer looks" : labelOf(found);
    if (focused instanceof HTMLElement && found.some((button) => button === focused)) focused.focus();
    describeSearch(looks, this.#finder.value, !found.length && looks.length > 0, (word) => this.search(word));
    this.#show();
  }

  /** Shows the looks that the search finds, from the best on. */
  #findFirst() {
    this.#find();
    if (this.#finder.value.trim()) this.#list.scrollTo({ left: 0, top: 0, behavior: "instant" });
  }

  /** Enter chooses the best look. @param {KeyboardEvent} event */
  #key(event) {
    const first = /** @type {HTMLButtonElement | null} */ (this.#list.firstElementChild);
    if (event.key === "Enter" && this.#finder.value.trim()) first?.click();
    else if (event.key === "ArrowDown") first?.focus();
    else if (event.key === "Escape") this.search("");
    else return;
    event.preventDefault();
  }

  /** Scrolls a row of looks so that the chosen one is in its middle. */
  #show() {
    const [list, button] = [this.#list, this.#chosen];
    if (!button?.isConnected) return;
    list.scrollTo({ left: button.offsetLeft - (list.clientWidth - button.offsetWidth) / 2, behavior: "smooth" });
  }
}
