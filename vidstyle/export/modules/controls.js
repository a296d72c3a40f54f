// Controls for the parameters of a style, as described by `vidstyle.style.panel`.

import { make, words } from "./elements.js";

/**
 * The elements that set a value, and a function that shows another value.
 * @typedef {object} Control
 * @property {HTMLElement[]} inline elements next to the name
 * @property {HTMLElement[]} [below] elements of the full width
 * @property {(value: any) => void} show
 */

/**
 * @typedef {object} Described
 * @property {string} name
 * @property {string} label its name in plain words
 * @property {string} kind
 * @property {number} [low]
 * @property {number} [high]
 * @property {boolean} [whole]
 * @property {string} [unit]
 * @property {string[]} [options]
 * @property {string} [none] what stands for an empty option
 */

/** Whether a unit fits next to a number. @param {string | undefined} unit */
export const isShort = (unit) => Boolean(unit) && String(unit).length < 8;

/** Rounds a value to three digits, or to an integer. @param {number} value @param {boolean | undefined} whole */
export const short = (value, whole) => (whole ? Math.round(value) : Number(value.toPrecision(3)));

const NOTCH_COUNT = 400;
/** A slider with equal steps sets round values: at least so many on its way. */
const MIN_ROUND_VALUES = 50;

/** Whether low values get most of the travel of a slider. @param {{low?: number, high?: number, whole?: boolean, unit?: string}} entry */
const isSteep = ({ low = 0, high = 1, whole, unit }) => !whole && (unit === "px" || (low > 0 && high / low >= 20));

/**
 * Maps values to positions on a slider; a slider of a wide range gives most of its travel to low values.
 * @param {Described} entry
 */
export function scaleOf({ low = 0, high = 1, whole, unit }) {
  const span = high - low;
  const power = isSteep({ low, high, whole, unit }) ? 3 : 1;
  const notches = whole ? span : NOTCH_COUNT;
  return {
    notches,
    /** @param {number} value */
    place: (value) => Math.pow((value - low) / span, 1 / power) * notches,
    /** @param {number} place */
    value: (place) => low + span * Math.pow(place / notches, power),
  };
}

/** Rounds a value that a slider sets: to an integer, a round step of its range, or two digits. @param {number} value @param {Described} entry */
function rounded(value, { low = 0, high = 1, whole, unit }) {
  if (whole) return Math.round(value);
  if (isSteep({ low, high, unit })) return Number(value.toPrecision(2));
  const digits = Math.max(0, -Math.floor(Math.log10((high - low) / MIN_ROUND_VALUES)));
  return Number(value.toFixed(digits));
}

/**
 * Controls by the `kind` with which a subclass of `Control` in Python describes itself.
 * @type {Record<string, (entry: Described, id: string, change: (value: any) => void) => Control>}
 */
const CONTROLS = { slider, switch: checkbox, color: colorWell, choice: menu };

/**
 * Returns a control for one parameter, which calls `change` on input.
 * @param {Described} entry
 * @param {string} id of its input
 * @param {(value: any) => void} change
 */
export function control(entry, id, change) {
  return CONTROLS[entry.kind](entry, id, change);
}

/** The unit of levels between black and white, and the level of white. */
const [LEVEL_UNIT, WHITE_LEVEL] = ["of 255", 255];

/**
 * Returns a control in plain units: without a long unit, and levels as parts of white, like other amounts.
 * @param {Described} entry
 * @param {string} id of its input
 * @param {(value: any) => void} change
 * @returns {Control}
 */
export function plainControl(entry, id, change) {
  const { unit, low = 0, high = WHITE_LEVEL, whole } = entry;
  if (unit !== LEVEL_UNIT) return control(isShort(unit) ? entry : { ...entry, unit: "" }, id, change);
  const levelOf = (/** @type {number} */ part) => (whole ? Math.round(WHITE_LEVEL * part) : Number((WHITE_LEVEL * part).toFixed(2)));
  const described = { ...entry, low: low / WHITE_LEVEL, high: high / WHITE_LEVEL, unit: "", whole: false };
  const made = control(described, id, (part) => change(levelOf(part)));
  return { ...made, show: (level) => made.show(level === null ? null : Number((level / WHITE_LEVEL).toFixed(3))) };
}

/**
 * @param {Described} _
 * @param {string} id
 * @param {(value: boolean) => void} change
 * @returns {Control}
 */
function checkbox(_, id, change) {
  const box = make("input", { type: "checkbox", id, onchange: () => change(box.checked) });
  return { inline: [box], show: (value) => void (box.checked = value) };
}

/**
 * @param {Described} _
 * @param {string} id
 * @param {(value: string) => void} change
 * @returns {Control}
 */
function colorWell(_, id, change) {
  const well = make("input", { type: "color", id, oninput: () => change(well.value) });
  return { inline: [well], show: (value) => void (well.value = value) };
}

/**
 * @param {Described} entry
 * @param {string} id
 * @param {(value: string) => void} change
 * @returns {Control}
 */
function menu(entry, id, change) {
  const list = make("select", { id, onchange: () => change(list.value) });
  /** @param {string} option */
  const add = (option) => list.append(make("option", { value: option, textContent: option ? words(option) : entry.none ?? "none" }));
  (entry.options ?? []).forEach(add);
  return {
    inline: [list],
    show: (value) => {
      if (![...list.options].some((option) => option.value === value)) add(value);
      list.value = value;
    },
  };
}

/**
 * @param {Described} entry
 * @param {string} id
 * @param {(value: number) => void} change
 * @returns {Control}
 */
function slider(entry, id, change) {
  const { low = 0, high = 1, whole, unit = "" } = entry;
  const scale = scaleOf(entry);
  const range = make("input", { type: "range", id, min: "0", max: String(scale.notches), step: whole ? "1" : "any" });
  // The slider is the only stop of the Tab key; Enter on it goes to the number.
  const exact = make("input", { type: "number", step: "any", min: String(low), max: String(high), tabIndex: -1 });
  exact.setAttribute("aria-label", `${entry.label}, as a number`);
  /** @param {number | null} value null: not set */
  const put = (value) => {
    exact.value = value === null ? "" : String(value);
    range.setAttribute("aria-valuetext", value === null ? "not set" : `${value} ${unit}`.trim());
    range.style.setProperty("--part", String(Number(range.value) / scale.notches));
  };
  /** @param {number | null} value */
  const show = (value) => {
    range.value = String(value === null ? 0 : scale.place(value));
    put(value === null ? null : Number(value.toPrecision(7)));
  };
  /** @param {number} place */
  const move = (place) => {
    const value = Math.min(Math.max(rounded(scale.value(place), entry), low), high);
    put(value);
    change(value);
  };
  range.oninput = () => move(Number(range.value));
  // With step "any" browsers disagree about arrow keys.
  range.onkeydown = (event) => {
    if (event.key === "Enter" && !event.ctrlKey && !event.metaKey) {
      event.preventDefault();
      return exact.select();
    }
    /** @type {Object<string, number>} */
    const keys = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 };
    const steps = keys[event.key];
    if (!steps || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    const step = Math.max(whole ? 1 : 0, scale.notches / 100);
    range.value = String(Number(range.value) + steps * Math.round(step));
    move(Number(range.value));
  };
  exact.onkeydown = (event) => {
    if (!["Enter", "Escape"].includes(event.key)) return;
    event.preventDefault();
    event.stopPropagation();
    if (event.key === "Escape") exact.value = String(short(scale.value(Number(range.value)), whole));
    range.focus();
  };
  exact.onchange = () => {
    if (exact.value === "" || !exact.checkValidity()) {
      exact.reportValidity();
      return;
    }
    const value = whole ? Math.round(Number(exact.value)) : Number(exact.value);
    range.value = String(scale.place(value));
    put(value);
    change(value);
  };
  const inline = unit ? [exact, make("span", { className: "unit", textContent: unit.replace(/^of /, "/ ") })] : [exact];
  return { inline, below: [range], show };
}
