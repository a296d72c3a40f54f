// Rows of parameters: name, number, slider, help, and a pin that makes the parameter a knob.

import { control, scaleOf } from "./controls.js";
import { icon, make, press } from "./elements.js";
import { renameButton } from "./rename.js";

/** @typedef {import("./types.js").Entry} Entry */
/** @typedef {{box: HTMLElement, pin: HTMLButtonElement | null, shown: import("./controls.js").Control, entry: Entry}} Row */

/** Words that say nothing. */
const FILLERS = new Set(["of", "the", "a", "between", "how", "is", "are"]);

/** Whether the help of a parameter says more than its label. @param {Entry} entry */
export function saysMore({ label, help }) {
  const wordsOf = (/** @type {string} */ text) => text.toLowerCase().split(/\W+/).map((word) => word.replace(/s$/, ""));
  const known = new Set(wordsOf(label));
  return wordsOf(help).some((word) => word && !known.has(word) && !FILLERS.has(word));
}

/** A list of parameters; its rows stay in place while only values change. */
export class ValueList {
  /** @type {Map<string, Row>} */
  #rows = new Map();
  #structure = "";
  #held = "";

  /**
   * @param {import("./session.js").Session} session
   * @param {boolean} pins whether to show pins
   */
  constructor(session, pins) {
    this.session = session;
    this.pins = pins;
    this.element = make("div", { className: "values" });
    addEventListener("pointerup", () => (this.#held = ""));
    addEventListener("pointercancel", () => (this.#held = ""));
  }

  /** @param {Entry[]} entries */
  show(entries) {
    const structure = JSON.stringify(entries.map(({ value, knob, ...rest }) => rest));
    if (structure !== this.#structure) this.#build(entries);
    this.#structure = structure;
    for (const entry of entries) this.#update(/** @type {Row} */ (this.#rows.get(entry.path)), entry);
  }

  /** @param {Entry[]} entries */
  #build(entries) {
    this.#rows.clear();
    for (const entry of entries) this.#rows.set(entry.path, this.#row(entry));
    this.element.replaceChildren(...[...this.#rows.values()].map((row) => row.box));
  }

  /** @param {Entry} entry @returns {Row} */
  #row(entry) {
    const id = `value-${this.pins ? "" : "knob-"}${entry.path}`;
    const shown = control(entry, id, (value) => this.#set(entry, value));
    const label = make("label", { htmlFor: id, textContent: entry.label, title: `${entry.path}\nDouble-click or Delete to reset: ${entry.start ?? "not set"}` });
    const rename = !this.pins && entry.knob ? this.#rename(entry, label) : null;
    if (rename) rename.tabIndex = -1; // F2 on the slider does the same
    // The pins of steps are in their own lists.
    const pin = this.pins || (entry.knob && entry.step === null) ? this.#pin(entry) : null;
    const button = rename ?? pin;
    const top = make("div", { className: "top" }, label, ...[rename, pin].filter((each) => each !== null), make("div", { className: "number" }, ...shown.inline));
    const parts = [top, ...(shown.below ? [this.#track(entry, shown.below)] : [])];
    const box = make("div", { className: "value" }, ...parts, ...(saysMore(entry) ? [make("p", { className: "help", textContent: entry.help })] : []));
    box.dataset.path = entry.path;
    label.addEventListener("dblclick", () => this.#reset(entry));
    shown.below?.[0].addEventListener("dblclick", () => this.#reset(entry));
    shown.below?.[0].addEventListener("keydown", (event) => {
      if (!["Delete", "Backspace", "F2"].includes(event.key)) return;
      event.preventDefault();
      event.stopPropagation();
      if (event.key === "F2") button?.click();
      else this.#reset(entry);
    });
    box.addEventListener("pointerdown", () => (this.#held = entry.path));
    return { box, pin, shown, entry };
  }

  /** Returns a slider with a mark at the value of the style as opened. @param {Entry} entry @param {HTMLElement[]} inside */
  #track(entry, inside) {
    const track = make("div", { className: "track" }, ...inside);
    const scale = scaleOf(entry);
    if (entry.start !== null) track.style.setProperty("--default", String(scale.place(entry.start) / scale.notches));
    return track;
  }

  /** @param {Entry} entry */
  #pin(entry) {
    const pin = make("button", { className: "pin", type: "button", title: this.pins ? "Pin to the style panel" : "Unpin: move to More settings" }, icon("pin"));
    pin.setAttribute("aria-label", this.pins ? `Pin ${entry.label} to the style panel` : `Unpin ${entry.label}`);
    pin.addEventListener("click", () => {
      const { step, name } = entry;
      this.session.edit("knob", { step, name, on: pin.getAttribute("aria-pressed") !== "true" });
    });
    return pin;
  }

  /** @param {Entry} entry @param {HTMLElement} label */
  #rename(entry, label) {
    const { step, name } = entry;
    return renameButton(entry, label, (text) => this.session.edit("label", { step, name, text }));
  }

  /** @param {Entry} entry */
  #reset(entry) {
    this.#rows.get(entry.path)?.shown.show(entry.start);
    this.#set(entry, entry.start);
  }

  /** @param {Entry} entry @param {any} value */
  #set(entry, value) {
    this.session.set(entry, value);
  }

  /** @param {Row} row @param {Entry} entry */
  #update(row, entry) {
    row.box.classList.toggle("changed", entry.value !== entry.start);
    press(row.pin, entry.knob);
    const typing = row.box.contains(document.activeElement) && document.activeElement?.matches("input[type=number]");
    if (this.#held === entry.path || this.session.isBusy(entry.path) || typing) return;
    row.shown.show(entry.value);
  }
}
