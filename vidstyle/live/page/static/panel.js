// The panel next to the picture, built from the parameters of the style.

import { isShort, plainControl, short } from "./controls.js";
import { get, make, press, title } from "./elements.js";
import { LookList } from "./look_list.js";
import { variantChip, withSwatches } from "./variant_chip.js";

/**
 * A parameter, as described by `vidstyle.style.panel`.
 * @typedef {import("./controls.js").Described & {
 *   path: string, value: any, start: any, help: string, main: boolean, layer: string, step: string, about: string,
 *   block_label?: string
 * }} Entry
 */

/**
 * @typedef {object} PanelState
 * @property {string} name
 * @property {string} variant
 * @property {string} note
 * @property {string} text command-line options
 * @property {{name: string, ink: string, paper: string}[]} variants
 * @property {Entry[]} entries
 */

/** @typedef {{path: string, value: any, start: any, control: import("./controls.js").Control, box: HTMLElement}} Row */

/** @param {{name: string, variant: string}} style */
const fullName = ({ name, variant }) => (variant ? `${name}:${variant}` : name);

/** Shows the styles and the parameters, and sends changes. */
export class Panel {
  /** @type {Record<string, Row>} */
  #rows = {};
  /** Values that wait until the earlier ones are answered. @type {Map<string, any>} */
  #queued = new Map();
  /** @type {Map<string, any> | null} */
  #inFlight = null;
  /** @type {string | null} */
  #dragged = null;
  /** The style and the parameters for which the rows were built. */
  #built = "";
  /** @type {PanelState | null} */
  #last = null;
  looks = new LookList((style) => this.choose("choose", { style }));

  /**
   * @param {(kind: string, fields?: object) => Promise<boolean>} send resolves to whether the message succeeded
   * @param {(style: string) => void} onchoose is called with the name of a style that is requested
   */
  constructor(send, onchoose) {
    this.send = send;
    this.onchoose = onchoose;
    addEventListener("pointerup", () => (this.#dragged = null));
    get("reset").onclick = () => this.#last && this.choose("choose", { style: fullName(this.#last) });
    get("copy").onclick = () => this.#copy();
  }

  /** @param {string[]} names */
  names(names) {
    this.looks.show(names);
    if (this.#last) this.#press(this.#last);
  }

  /** Requests another style; discards changes that are not sent yet. @param {string} kind @param {{style: string}} [fields] */
  choose(kind, fields) {
    this.#queued.clear();
    if (fields) this.onchoose(fields.style);
    this.send(kind, fields);
  }

  /** @param {number} step */
  changeSteady(step) {
    const row = this.#rows.steady;
    if (!row) return;
    const value = short(Math.min(Math.max(row.value + step, 0), 1), false);
    row.control.show(value);
    this.#set(row, value);
  }

  /** @param {PanelState} panel */
  show(panel) {
    this.#last = panel;
    const built = JSON.stringify([panel.name, panel.entries.map((entry) => entry.path)]);
    if (built !== this.#built) this.#build(panel);
    this.#built = built;
    for (const entry of panel.entries) this.#update(entry);
    get("options").textContent = panel.text;
    this.#press(panel);
    for (const step of document.querySelectorAll("#steps details"))
      /** @type {HTMLElement} */ (step.querySelector(".mark")).hidden = !step.querySelector(".changed");
    /** @type {HTMLButtonElement} */ (get("reset")).disabled = panel.entries.every((entry) => entry.value === entry.start);
  }

  /** @param {Entry} entry */
  #update({ path, value, start }) {
    const row = this.#rows[path];
    row.box.classList.toggle("changed", value !== start);
    if (this.#dragged === path || this.#queued.has(path) || this.#inFlight?.has(path)) return;
    Object.assign(row, { value, start });
    if (!row.box.querySelector("input[type=number]:focus")) row.control.show(value);
  }

  /** @param {PanelState} panel */
  #press(panel) {
    this.looks.choose(panel.name, fullName(panel));
    for (const button of /** @type {Iterable<HTMLElement>} */ (get("variants").children))
      press(button, button.dataset.name === panel.variant);
  }

  /** @param {PanelState} panel */
  #build(panel) {
    this.#rows = {};
    const [about] = panel.note.split(" Tune ");
    get("about").textContent = about || "The unchanged picture.";
    const [ink, paper] = ["ink", "paper"].map((path) => panel.entries.find((entry) => entry.path === path)?.start);
    const variants = panel.variants.length ? [{ name: "", ink, paper }, ...panel.variants] : [];
    get("variants").replaceChildren(...withSwatches(variants).map((variant) => {
      const style = fullName({ name: panel.name, variant: variant.name });
      return variantChip(variant, () => {
        this.onchoose(style);
        this.send("vary", { variant: variant.name });
      });
    }));
    // The knobs of the style, and what every live picture needs.
    const knobs = panel.entries.filter((entry) => entry.main && (entry.step || entry.path === "steady"));
    knobs.sort((one, other) => Number(!one.step) - Number(!other.step));
    get("main").replaceChildren(...knobs.map((entry) => this.#row(entry)));
    const common = panel.entries.filter((entry) => entry.main && !knobs.includes(entry));
    get("common").replaceChildren(...common.map((entry) => this.#row(entry)));
    const layers = Map.groupBy(panel.entries.filter((entry) => !entry.main), (entry) => entry.layer);
    get("steps").replaceChildren(...[...layers].flatMap(([layer, entries]) => this.#layer(layer, entries)));
  }

  /** @param {string} layer @param {Entry[]} entries */
  #layer(layer, entries) {
    const groups = [...Map.groupBy(entries, (entry) => entry.step)];
    const steps = groups.map(([step, inside], at) => this.#step(step, inside, groups[at + 1]?.[1][0].block_label ?? ""));
    return layer ? [make("h3", { textContent: title(layer) }), ...steps] : steps;
  }

  /** @param {string} step @param {Entry[]} entries @param {string} next label of the block after it, which tells equal blocks apart */
  #step(step, entries, next) {
    const mark = make("span", { className: "mark", textContent: " changed", hidden: true });
    const about = entries[0].about ? [make("p", { className: "about", textContent: entries[0].about })] : [];
    const inside = make("div", {}, ...about, ...entries.map((entry) => this.#row(entry)));
    const number = step.match(/#(\d+)$/)?.[1] ?? "";
    const place = !number ? "" : next && next !== entries[0].block_label ? ` before ${next.toLowerCase()}` : ` ${number}`;
    const name = step ? entries[0].block_label + place : "Size";
    return make("details", {}, make("summary", { title: step }, name, mark), inside);
  }

  /** @param {Entry} entry */
  #row(entry) {
    const { path, value, start, main, help, unit } = entry;
    const id = `value-${path}`;
    const made = plainControl(entry, id, (changed) => this.#set(row, changed));
    const label = make("label", { htmlFor: id, title: `${help}\n${path}` }, entry.label);
    label.ondblclick = () => {
      made.show(row.start);
      this.#set(row, row.start);
    };
    const top = make("div", { className: "top" }, label, make("div", { className: "value" }, ...made.inline));
    const long = unit && !isShort(unit) ? unit : "";
    const about = main || long ? [make("p", { className: "help", textContent: main ? help + (long && ` (${long})`) : long })] : [];
    const box = make("div", { className: "entry", title: help }, top, ...(made.below ?? []), ...about);
    box.onpointerdown = () => (this.#dragged = path);
    /** @type {Row} */
    const row = { path, value, start, control: made, box };
    made.show(value);
    this.#rows[path] = row;
    return box;
  }

  /** @param {Row} row @param {any} value */
  #set(row, value) {
    row.value = value;
    this.#queued.set(row.path, value);
    this.#flush();
  }

  /** Sends the queued values; after an error, shows the current values again. */
  async #flush() {
    if (this.#inFlight || !this.#queued.size) return;
    this.#inFlight = this.#queued;
    this.#queued = new Map();
    const isSet = await this.send("set", { values: Object.fromEntries(this.#inFlight) });
    this.#inFlight = null;
    if (!isSet && this.#last) this.show(this.#last);
    this.#flush();
  }

  async #copy() {
    const [copy, options] = [get("copy"), get("options")];
    try {
      await navigator.clipboard.writeText(options.textContent ?? "");
      copy.textContent = "Copied";
    } catch {
      getSelection()?.selectAllChildren(options);
      copy.textContent = "Selected";
    }
    setTimeout(() => (copy.textContent = "Copy"), 1500);
  }
}
