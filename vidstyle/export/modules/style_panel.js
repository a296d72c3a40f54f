// The knobs, colours and variants of a style.

import { plainControl } from "./controls.js";
import { get, make, press } from "./elements.js";
import { addressedStyle, addressedValues } from "./shared_link.js";
import { variantChip, withSwatches } from "./variant_chip.js";

/** @typedef {import("./plan_values.js").Entry} Entry */
/** @typedef {import("./viewer.js").StyleData} StyleData */


/** Returns what a value does; the part after a semicolon is shown while the value is changed. @param {string} help */
function helpOf(help) {
  const [first, ...rest] = help.split(";");
  return make("p", { className: "help", title: help }, first, make("span", { className: "rest", textContent: rest.map((part) => `;${part}`).join("") }));
}

/** Shows the controls of a style in the elements `controls`, `variants` and `reset`. */
export class StylePanel {
  /** The values of the controls by path. @type {Record<string, any>} */
  values = {};
  /** @type {Record<string, (value: any) => void>} */
  #show = {};
  /** The rows of the values by path. @type {Map<string, HTMLElement>} */
  #rows = new Map();
  /** The controls, with the ranges that the plans allow. @type {Entry[]} */
  #entries = [];
  /** The paths of the values that any variant sets. @type {string[]} */
  #named = [];
  /** The values before the reset; null if a value was set since. @type {Record<string, any> | null} */
  #before = null;

  /**
   * @param {StyleData} data
   * @param {() => void} onchange
   */
  constructor(data, onchange) {
    this.data = data;
    this.onchange = onchange;
    for (const parent of ["controls", "variants"]) get(parent).replaceChildren();
    for (const entry of data.controls) this.#add(entry);
    this.initial = { ...this.values };
    this.#named = Object.keys(Object.assign({}, ...Object.values(data.variants)));
    const names = Object.keys(data.variants);
    const variants = (names.length ? ["", ...names] : []).map((name) => this.#variantOf(name));
    get("variants").append(...withSwatches(variants).map((variant) => variantChip(variant, () => this.#vary(variant.name))));
    get("reset").onclick = () => this.put(this.#before ?? this.initial, this.#before ? null : { ...this.values });
    this.put(addressedStyle() === data.name ? addressedValues(this.#entries) : {});
  }

  /** The values that differ from the style's own, by path. */
  get changes() {
    return Object.fromEntries(Object.entries(this.values).filter(([path, value]) => value !== this.initial[path]));
  }

  /** Sets values. @param {Record<string, any>} wanted by path @param {Record<string, any> | null} [before] to which the button Reset then returns */
  put(wanted, before = null) {
    for (const [path, value] of Object.entries(wanted)) {
      this.values[path] = value;
      this.#show[path](value);
    }
    this.#changed(before);
  }

  /** @param {Entry} entry */
  #add(entry) {
    const { path, kind, help } = entry;
    const ranges = this.data.plans.map(({ tables }) => tables[path][0].at);
    // A slider ends where a plan would need other passes.
    const ends = { low: Math.max(...ranges.map((at) => at[0])), high: Math.min(...ranges.map((at) => at[at.length - 1])) };
    const described = { ...entry, ...(kind === "slider" ? ends : {}) };
    const shown = plainControl(described, `value-${path}`, (value) => {
      this.values[path] = value;
      this.#changed();
    });
    const label = make("label", { htmlFor: `value-${path}`, textContent: entry.label });
    const row = make("div", { className: "control" }, label, make("div", { className: "value" }, ...shown.inline), ...(shown.below ?? []), helpOf(help));
    get("controls").append(row);
    this.#rows.set(path, row);
    this.#entries.push(described);
    this.values[path] = entry.value;
    this.#show[path] = shown.show;
    shown.show(entry.value);
  }

  /** Returns a variant with its colours. @param {string} name "": the values of the style itself */
  #variantOf(name) {
    const values = { ...this.initial, ...this.data.variants[name] };
    const colors = this.#named.filter((path) => path.includes(".") && /^#[0-9a-f]{6}$/i.test(values[path])).map((path) => values[path]);
    return { name, ink: values.ink, paper: values.paper, colors };
  }

  /** The name of the variant that is shown, whatever else is changed; "": the style itself; null: none. @returns {string | null} */
  get #variant() {
    const { variants } = this.data;
    const sizeOf = (/** @type {string} */ name) => Object.keys(variants[name]).length;
    const found = Object.keys(variants).filter((name) => sizeOf(name) && Object.entries(variants[name]).every(([path, value]) => this.values[path] === value));
    found.sort((one, other) => sizeOf(other) - sizeOf(one));
    return found[0] ?? (this.#named.every((path) => this.values[path] === this.initial[path]) ? "" : null);
  }

  /** Shows a variant; a value that it does not set, and that the present one does not, stays. @param {string} name */
  #vary(name) {
    const { variants } = this.data;
    const left = Object.keys(variants[this.#variant ?? ""] ?? {});
    const reset = left.length ? left : this.#named;
    this.put({ ...Object.fromEntries(reset.map((path) => [path, this.initial[path]])), ...variants[name] });
  }

  /** @param {Record<string, any> | null} [before] */
  #changed(before = null) {
    this.#before = before;
    for (const [path, row] of this.#rows) row.classList.toggle("changed", this.values[path] !== this.initial[path]);
    const shown = this.#variant;
    for (const button of /** @type {Iterable<HTMLElement>} */ (get("variants").children)) press(button, button.dataset.name === shown);
    const reset = /** @type {HTMLButtonElement} */ (get("reset"));
    reset.disabled = !before && !Object.keys(this.changes).length;
    reset.textContent = before ? "Undo reset" : "Reset";
    this.onchange();
  }
}
