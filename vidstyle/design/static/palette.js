// The palette: a dialog to find and add blocks.

import { get, make } from "./elements.js";

/** @typedef {import("./types.js").Block} Block */
/** @typedef {import("./types.js").Entry} Entry */
/** @typedef {{blocks: string[], values: string[], values_first: boolean, note: string}} Found blocks, and paths of values, that a text describes, best first; whether it is the name of the first value; a note if the blocks only come near */

/** Distance to its button and to the edges of the window, in CSS pixels. */
const GAP_PX = 12;

/** A searchable list of all blocks. */
export class Palette {
  /** @type {Block[]} */
  #blocks = [];
  /** @type {HTMLElement[]} */
  #options = [];
  #at = 0;
  /** @type {(block: string) => void} */
  #chosen = () => {};
  #asked = "";
  /** Returns whether steps were copied in this browser. @type {() => boolean} */
  canPaste = () => false;
  /** Is called to paste them at the position of the palette. @type {() => void} */
  onpaste = () => {};
  /** Resolves once the list shows what is asked. */
  #listed = Promise.resolve();

  /**
   * @param {import("./session.js").Session} session
   * @param {(field: string) => void} showField shows a setting of the style
   */
  constructor(session, showField) {
    this.session = session;
    this.showField = showField;
    this.dialog = get("palette");
    this.search = /** @type {HTMLInputElement} */ (get("search"));
    this.list = get("blocks");
    this.search.addEventListener("input", () => (this.#listed = this.#filter()));
    this.search.addEventListener("keydown", (event) => this.#key(event));
    this.dialog.addEventListener("click", (event) => {
      if (event.target === this.dialog) this.close();
    });
  }

  /** @param {Block[]} blocks */
  fill(blocks) {
    this.#blocks = blocks;
  }

  /**
   * Opens the palette next to an element.
   * @param {string} where the layer and the place in it, as text
   * @param {DOMRect | null} near
   * @param {(block: string) => void} chosen
   */
  open(where, near, chosen) {
    this.#chosen = chosen;
    this.search.value = "";
    this.search.placeholder = "Search: outline, blur, paper…";
    get("palette-where").textContent = `Add to ${where}`;
    this.#filter();
    const dialog = /** @type {HTMLDialogElement} */ (this.dialog);
    dialog.showModal();
    this.#place(near);
    this.search.focus();
  }

  close() {
    /** @type {HTMLDialogElement} */ (this.dialog).close();
  }

  /** Places the dialog next to its button, where it stays while its list changes. @param {DOMRect | null} near */
  #place(near) {
    const { width, height } = this.dialog.getBoundingClientRect();
    const [maxLeft, maxTop] = [innerWidth - width - GAP_PX, innerHeight - height - GAP_PX];
    let [left, top] = [(innerWidth - width) / 2, (innerHeight - height) / 2];
    if (near && innerWidth > 2 * width) {
      left = near.right + GAP_PX <= maxLeft ? near.right + GAP_PX : near.left - width - GAP_PX;
      top = near.top - height / 4;
    } else if (near) top = near.bottom + GAP_PX;
    const inside = (/** @type {number} */ place, /** @type {number} */ most) => `${Math.max(GAP_PX, Math.min(place, most))}px`;
    Object.assign(this.dialog.style, { left: inside(left, maxLeft), top: inside(top, maxTop) });
  }

  async #filter() {
    const text = this.search.value.trim();
    this.#asked = text;
    if (!text) return this.#list([...(this.canPaste() ? [this.#paste()] : []), ...this.#categories()]);
    const found = /** @type {Found | null} */ (await this.session.ask("find", { text }));
    if (!found || text !== this.#asked) return;
    const blocks = this.#matches(found);
    // Settings that only share a word with the name of a block are no answer.
    const settings = found.values_first || found.note || !blocks.length ? this.#settings(found.values) : [];
    this.#list([...this.#note(found), ...(found.values_first ? [...settings, ...blocks] : [...blocks, ...settings])]);
  }

  /** @param {HTMLElement[]} parts */
  #list(parts) {
    this.list.dataset.asked = this.#asked;
    const empty = make("p", { className: "quiet", textContent: "No matching blocks. Try another word, such as outline, blur or paper." });
    empty.setAttribute("role", "status");
    this.list.replaceChildren(...(parts.length ? parts : [empty]));
    this.#options = /** @type {HTMLElement[]} */ ([...this.list.querySelectorAll("[role=option]")]);
    this.#go(0);
  }

  /** Returns all blocks under the headings of their categories. */
  #categories() {
    const groups = Map.groupBy(this.#blocks, ({ category }) => category);
    return [...groups].map(([name, blocks]) => this.#group(name, blocks.map((block) => this.#option(block))));
  }

  /** @param {Found} found */
  #matches({ blocks }) {
    const byName = new Map(this.#blocks.map((block) => [block.name, block]));
    return blocks.flatMap((name) => byName.get(name) ?? []).map((block) => this.#option(block));
  }

  /** @param {Found} found */
  #note({ note }) {
    const line = make("p", { className: "quiet", textContent: note.replaceAll("`", "") });
    line.setAttribute("role", "status");
    return note ? [line] : [];
  }

  /** Returns the settings of the style that fit. @param {string[]} paths */
  #settings(paths) {
    const { fields, knobs } = this.session.state ?? { fields: [], knobs: [] };
    const found = paths.flatMap((path) => [...knobs, ...fields].find((entry) => entry.path === path) ?? []);
    return found.length ? [this.#group("Settings of the style", found.map((entry) => this.#setting(entry)))] : [];
  }

  /** @param {string} name @param {HTMLElement[]} options */
  #group(name, options) {
    const head = make("span", { className: "heading", textContent: name, ariaHidden: "true" });
    const group = make("div", {}, head, ...options);
    group.setAttribute("role", "group");
    group.setAttribute("aria-label", name);
    return group;
  }

  #paste() {
    const text = make("div", {}, make("b", { textContent: "Paste" }), make("span", { textContent: "Add the steps that you copied, here or in another style." }));
    return this.#choice(make("div", { className: "option", id: "paste" }, text), () => this.onpaste());
  }

  /** @param {Entry} entry */
  #setting({ label, help, path }) {
    const text = make("div", {}, make("b", { textContent: label }), make("span", { textContent: help }));
    return this.#choice(make("div", { className: "option", id: `setting-${path}` }, text), () => this.showField(path));
  }

  /** @param {Block} block */
  #option(block) {
    const picture = make("img", { src: this.session.sampleAt(block.name), alt: "", loading: "lazy", width: 80, height: 45 });
    const text = make("div", {}, make("b", { textContent: block.label }), make("span", { textContent: block.help }));
    const option = make("div", { className: "option", id: `block-${block.name}`, title: `In style files: ${block.name}` }, picture, text);
    option.dataset.block = block.name;
    return this.#choice(option, () => this.#chosen(block.name));
  }

  /** Makes an element an option. @param {HTMLElement} option @param {() => void} choose */
  #choice(option, choose) {
    option.setAttribute("role", "option");
    option.setAttribute("aria-selected", "false");
    option.addEventListener("click", () => {
      this.close();
      choose();
    });
    option.addEventListener("pointermove", () => this.#options[this.#at] !== option && this.#go(this.#options.indexOf(option), false));
    return option;
  }

  /** @param {number} at @param {boolean} [scroll] */
  #go(at, scroll = true) {
    this.#options[this.#at]?.setAttribute("aria-selected", "false");
    this.#at = Math.max(0, Math.min(this.#options.length - 1, at));
    const option = this.#options[this.#at];
    this.search.setAttribute("aria-activedescendant", option?.id ?? "");
    option?.setAttribute("aria-selected", "true");
    if (scroll) option?.scrollIntoView({ block: at ? "nearest" : "end" });
    if (scroll && !at) this.list.scrollTop = 0;
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const steps = { ArrowDown: 1, ArrowUp: -1, PageDown: 6, PageUp: -6 }[event.key];
    if (steps) this.#go(this.#at + steps);
    else if (event.key === "Escape") this.close();
    else if (event.key === "Enter") this.#listed.then(() => this.#options[this.#at]?.click());
    else return;
    event.preventDefault();
  }
}
