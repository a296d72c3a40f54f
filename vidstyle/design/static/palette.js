// The palette: a dialog to find and add blocks.

import { get, make } from "./elements.js";

/** @typedef {import("./types.js").Block} Block */
/** @typedef {import("./types.js").Entry} Entry */
/** @typedef {{blocks: string[], values: string[], values_first: boolean, note: string}} Found blocks, and paths of values, that a text describes, best first; whether it is the name of the first value; a note if the blocks only come near */

/** Next to its button the list is at least this high; with less room it covers the button. */
const MIN_HEIGHT_PX = 360;

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

  /** @param {DOMRect | null} near */
  #place(near) {
    const { style } = this.dialog;
    style.maxHeight = "";
    const room = near ? Math.max(near.top, innerHeight - near.bottom) - 24 : innerHeight;
    if (room >= MIN_HEIGHT_PX) style.maxHeight = `${room}px`;
    const { width, height } = this.dialog.getBoundingClientRect();
    const x = near ? near.left + near.width / 2 - width / 2 : (innerWidth - width) / 2;
    const y = near ? near.top - height - 12 : (innerHeight - height) / 2;
    const left = Math.min(innerWidth - width - 12, Math.max(12, x));
    const top = y < 12 && near ? Math.min(innerHeight - height - 12, near.bottom + 12) : y;
    Object.assign(style, { left: `${left}px`, top: `${Math.max(12, top)}px` });
  }

  async #filter() {
    const text = this.search.value.trim();
    this.#asked = text;
    if (!text) return this.#list([...(this.canPaste() ? [this.#paste()] : []), ...this.#categories()]);
    const found = /** @type {Found | null} */ (await this.session.ask("find", { text }));
    if (!found || text !== this.#asked) return;
    const [blocks, settings] = [this.#matches(found), this.#settings(found.values)];
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
    const name = make("b", {}, block.label, make("small", { textContent: block.name }));
    const text = make("div", {}, name, make("span", { textContent: block.help }));
    const option = make("div", { className: "option", id: `block-${block.name}` }, picture, text);
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
    else if (event.key === "Enter") this.#listed.then(() => this.#options[this.#at]?.click());
    else return;
    event.preventDefault();
  }
}
