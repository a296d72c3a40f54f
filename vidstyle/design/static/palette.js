// The palette: a dialog to find and add blocks.

import { get, make, title, words } from "./elements.js";

/** @typedef {import("./types.js").Block} Block */

/** Headings of the kinds of blocks, in the order of the palette. @type {Object<string, string>} */
const KIND_HEADINGS = {
  pixel: "Tone and colour, per pixel",
  filter: "Neighbourhood filters",
  learned: "Learned filters",
  recipe: "Ready-made combinations",
  measured: "Contrast from measurements of the whole picture",
  resize: "Size",
};

/** A searchable list of all blocks. */
export class Palette {
  /** @type {Block[]} */
  #blocks = [];
  /** @type {HTMLElement[]} */
  #options = [];
  #at = 0;
  /** @type {(block: string) => void} */
  #chosen = () => {};

  constructor() {
    this.dialog = get("palette");
    this.search = /** @type {HTMLInputElement} */ (get("search"));
    this.list = get("blocks");
    this.search.addEventListener("input", () => this.#filter());
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
   * @param {string} where the layer and the position, as text
   * @param {DOMRect | null} near
   * @param {(block: string) => void} chosen
   */
  open(where, near, chosen) {
    this.#chosen = chosen;
    this.search.value = "";
    this.search.placeholder = `Add to ${where}`;
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
    const { width, height } = this.dialog.getBoundingClientRect();
    const x = near ? near.left + near.width / 2 - width / 2 : (innerWidth - width) / 2;
    const y = near ? near.top - height - 12 : (innerHeight - height) / 2;
    const left = Math.min(innerWidth - width - 12, Math.max(12, x));
    const top = y < 12 && near ? Math.min(innerHeight - height - 12, near.bottom + 12) : y;
    Object.assign(this.dialog.style, { left: `${left}px`, top: `${Math.max(12, top)}px` });
  }

  #filter() {
    const asked = this.search.value.toLowerCase().trim();
    const found = this.#blocks.filter(({ name, help }) => `${words(name)} ${name} ${help}`.toLowerCase().includes(asked));
    const rank = /** @param {Block} block */ ({ name }) => (words(name).startsWith(asked) || name.startsWith(asked) ? 0 : 1);
    const kinds = [...new Set([...Object.keys(KIND_HEADINGS), ...found.map((block) => block.kind)])];
    this.#options = [];
    const groups = asked
      ? [this.#group("", [...found].sort((one, other) => rank(one) - rank(other)))]
      : kinds.map((kind) => this.#group(KIND_HEADINGS[kind] ?? kind, found.filter((block) => block.kind === kind)));
    const empty = make("p", { className: "quiet", textContent: "No matching blocks." });
    this.list.replaceChildren(...(found.length ? groups.flat() : [empty]));
    this.#go(0);
  }

  /** @param {string} name @param {Block[]} blocks */
  #group(name, blocks) {
    const head = name && blocks.length ? [make("h3", { textContent: name })] : [];
    return [...head, ...blocks.map((block) => this.#option(block))];
  }

  /** @param {Block} block */
  #option(block) {
    const number = this.#options.length;
    const picture = make("img", { src: block.picture, alt: "", loading: "lazy", width: 80, height: 45 });
    const text = make("div", {}, make("b", { textContent: title(block.name) }), make("span", { textContent: block.help }));
    const option = make("div", { className: "option", id: `block-${block.name}` }, picture, text);
    option.setAttribute("role", "option");
    option.addEventListener("click", () => this.#take(block.name));
    option.addEventListener("pointermove", () => this.#at !== number && this.#go(number, false));
    option.dataset.block = block.name;
    this.#options.push(option);
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
    else if (event.key === "Enter") this.#take(this.#options[this.#at]?.dataset.block);
    else return;
    event.preventDefault();
  }

  /** @param {string | undefined} block */
  #take(block) {
    if (!block) return;
    this.close();
    this.#chosen(block);
  }
}
