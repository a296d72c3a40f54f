// The panel next to the picture, built from the parameters of the style.

import { control, isShort, short } from "./controls.js";
import { get, make, press, title } from "./elements.js";
import { variantChip } from "./variant_chip.js";

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

/** The gap between the rows of looks, about. */
const ROW_GAP_PX = 9;

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

  /** @param {(kind: string, fields?: object) => Promise<boolean>} send resolves to whether the message succeeded */
  constructor(send) {
    this.send = send;
    addEventListener("pointerup", () => (this.#dragged = null));
    addEventListener("resize", () => this.#showChosen());
    get("reset").onclick = () => this.#last && this.choose("choose", { style: fullName(this.#last) });
    get("copy").onclick = () => this.#copy();
  }

  /** @param {string[]} names */
  names(names) {
    get("styles").replaceChildren(...names.map((name) => {
      const picture = make("img", { src: `thumbnail.jpg?of=${encodeURIComponent(name)}`, alt: "", width: 240, height: 135 });
      const onclick = () => this.choose("choose", { style: name });
      const button = make("button", { title: title(name), onclick }, picture, make("span", { textContent: title(name) }));
      button.dataset.name = name;
      return button;
    }));
    if (this.#last) this.#press(this.#last);
  }

  /** Requests another style; discards changes that are not sent yet. @param {string} kind @param {object} [fields] */
  choose(kind, fields) {
    this.#queued.clear();
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
    const full = fullName(panel);
    const styles = /** @type {HTMLElement[]} */ ([...get("styles").children]);
    // A session that was started with a variant lists it among the styles.
    const pressed = styles.some((button) => button.dataset.name === full) ? full : panel.name;
    for (const button of styles) {
      const chosen = button.dataset.name === pressed;
      if (chosen && button.ariaPressed !== "true") this.#scrollTo(button);
      press(button, chosen);
    }
    for (const button of /** @type {Iterable<HTMLElement>} */ (get("variants").children))
      press(button, button.dataset.name === panel.variant);
  }

  /**
   * Scrolls a style into the second row of the list or, in a narrow window, the middle of the row; scrollIntoView would scroll the page too.
   * @param {HTMLElement} button
   */
  #scrollTo(button) {
    const row = get("styles");
    const [left, top] = [button.offsetLeft - (row.clientWidth - button.clientWidth) / 2, button.offsetTop - button.offsetHeight - ROW_GAP_PX];
    row.scrollTo({ left, top, behavior: "smooth" });
  }

  /** Keeps the chosen style in view when the list becomes a row, or rows. */
  #showChosen() {
    const chosen = /** @type {HTMLElement | null} */ (get("styles").querySelector("[aria-pressed=true]"));
    if (chosen) this.#scrollTo(chosen);
  }

  /** @param {PanelState} panel */
  #build(panel) {
    this.#rows = {};
    const [about] = panel.note.split(" Tune ");
    get("about").textContent = about || "The unchanged picture.";
    get("variants").replaceChildren(...panel.variants.map((variant) => {
      const style = fullName({ name: panel.name, variant: variant.name });
      return variantChip(variant, () => this.choose("choose", { style }));
    }));
    const main = panel.entries.filter((entry) => entry.main);
    // The order of the designer: the knobs, then these.
    const later = ["strength", "steady", "focus"];
    main.sort((one, other) => later.indexOf(one.path) - later.indexOf(other.path));
    get("main").replaceChildren(...main.map((entry) => this.#row(entry)));
    const layers = Map.groupBy(panel.entries.filter((entry) => !entry.main), (entry) => entry.layer);
    get("steps").replaceChildren(...[...layers].flatMap(([layer, entries]) => this.#layer(layer, entries)));
    get("all").hidden = !layers.size;
  }

  /** @param {string} layer @param {Entry[]} entries */
  #layer(layer, entries) {
    const steps = [...Map.groupBy(entries, (entry) => entry.step)].map(([step, inside]) => this.#step(step, inside));
    return layer ? [make("h3", { textContent: layer }), ...steps] : steps;
  }

  /** @param {string} step @param {Entry[]} entries */
  #step(step, entries) {
    const mark = make("span", { className: "mark", textContent: " changed", hidden: true });
    const about = entries[0].about ? [make("p", { className: "about", textContent: entries[0].about })] : [];
    const inside = make("div", {}, ...about, ...entries.map((entry) => this.#row(entry)));
    const number = step.match(/#(\d+)$/)?.[1] ?? "";
    const name = step ? `${entries[0].block_label} ${number}`.trim() : "Size";
    return make("details", {}, make("summary", { title: step }, name, mark), inside);
  }

  /** @param {Entry} entry */
  #row(entry) {
    const { path, value, start, main, help, unit } = entry;
    const id = `value-${path}`;
    const described = main && !isShort(unit) ? { ...entry, unit: "" } : entry;
    const made = control(described, id, (changed) => this.#set(row, changed));
    const label = make("label", { htmlFor: id, title: `${help}\n${path}` }, entry.label);
    label.ondblclick = () => {
      made.show(row.start);
      this.#set(row, row.start);
    };
    const top = make("div", { className: "top" }, label, make("div", { className: "value" }, ...made.inline));
    const about = main ? [make("p", { className: "help", textContent: help + (unit && !isShort(unit) ? ` (${unit})` : "") })] : [];
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
