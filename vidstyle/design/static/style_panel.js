// The style panel: knobs, variants, colours and note.

import { make, press } from "./elements.js";
import { rove } from "./roving.js";
import { stepsOf } from "./types.js";
import { ValueList } from "./values.js";
import { variantChip } from "./variant_chip.js";

/** @typedef {import("./types.js").State} State */

/** Fields of the style that are shown below its knobs. */
const MAIN_FIELDS = ["strength"];
/** The field that few need. */
const LAST_FIELD = "height";

/** @typedef {import("./variant_chip.js").Variant} Variant */

/** Returns the variants without their colours if all have the same. @param {Variant[]} variants @returns {Variant[]} */
function differing(variants) {
  const colors = new Set(variants.map(({ name, ...rest }) => JSON.stringify(rest)));
  return colors.size > 1 ? variants : variants.map(({ name }) => ({ name }));
}

/** Shows and edits the style as a whole. */
export class StylePanel {
  /** Whether a film or camera is open: temporal smoothing has no effect on a photograph. */
  isFilm = true;
  /** The end of the note, which names values as in style files. */
  advice = "";

  /** @param {import("./session.js").Session} session @param {() => void} onadd adds the first step of a new style */
  constructor(session, onadd) {
    this.session = session;
    this.knobs = new ValueList(session, false);
    this.main = new ValueList(session, false);
    this.fields = new ValueList(session, true);
    this.note = make("textarea", { id: "note", rows: 4, maxLength: 2000, placeholder: "What this style looks like" });
    this.note.addEventListener("change", () => session.edit("note", { text: this.note.value + this.advice }));
    this.variants = make("div", { className: "chips" });
    this.variants.setAttribute("role", "group");
    this.variants.setAttribute("aria-label", "Variants");
    rove(this.variants, "button");
    this.first = make("div", { className: "first" }, make("p", { className: "quiet", textContent: "This style has no steps yet: it changes nothing." }), make("button", { type: "button", className: "strong", textContent: "Add a first step…", onclick: onadd }));
    this.none = make("p", { className: "quiet", textContent: "No values are pinned yet. Choose a step in the diagram, and pin one of its values to show it here." });
    this.errors = make("div", { className: "error" });
    this.more = make("details", {}, make("summary", { textContent: "More settings" }), this.fields.element,
      make("label", { htmlFor: "note", textContent: "Note", className: "above" }), this.note);
    this.about = make("p", { className: "about" });
    this.element = make("div", { className: "style-panel" }, this.errors, this.about, this.variants, this.first, this.none, this.knobs.element,
      this.main.element, this.more);
    this.element.hidden = true; // until a style is open
  }

  /** Focuses a field of the style. @param {string} name */
  focus(name) {
    const field = /** @type {HTMLElement | null} */ (this.element.querySelector(`[data-path="${name}"] :is(input, select)`));
    if (field && this.more.contains(field)) this.more.open = true;
    field?.focus();
    field?.scrollIntoView({ block: "nearest" });
  }

  /** Shows the variants; their buttons keep the focus while only values change. @param {State} state */
  #showVariants({ variants, variant }) {
    const shown = JSON.stringify(variants);
    if (this.variants.dataset.shown !== shown)
      this.variants.replaceChildren(...differing(variants).map((each) => variantChip(each, () => this.#vary(each.name))));
    this.variants.dataset.shown = shown;
    this.variants.hidden = !variants.length;
    this.#press(variant);
  }

  /** Chooses a variant; its button shows it at once, the picture when it is rendered. @param {string} name */
  #vary(name) {
    this.#press(name);
    return this.session.edit("variant", { name });
  }

  /** @param {string | null} variant */
  #press(variant) {
    for (const chip of this.variants.children) press(chip, /** @type {HTMLElement} */ (chip).dataset.name === variant);
  }

  /** @param {State} state */
  show(state) {
    this.element.hidden = false;
    const [about] = state.note.split(" Tune ");
    this.about.textContent = about;
    this.errors.replaceChildren(...state.errors.map((text) => make("p", { textContent: text })));
    this.errors.hidden = !state.errors.length;
    this.#showVariants(state);
    this.knobs.show(state.knobs);
    const hasSteps = stepsOf(state).length > 0, isNew = !state.knobs.length;
    this.first.hidden = hasSteps;
    this.none.hidden = !hasSteps || state.knobs.length > 0;
    /** @param {import("./types.js").Entry} entry */
    const isMain = (entry) => (MAIN_FIELDS.includes(entry.name) || (isNew && entry.kind === "color")) && !entry.knob;
    const hasEffect = (/** @type {import("./types.js").Entry} */ { name }) => this.isFilm || name !== "steady";
    this.main.show(state.fields.filter(isMain));
    const isLast = (/** @type {import("./types.js").Entry} */ { name }) => name === LAST_FIELD;
    const others = state.fields.filter((entry) => !entry.knob && !isMain(entry) && hasEffect(entry)); // pinned ones are above
    this.fields.show(others.sort((one, other) => Number(isLast(one)) - Number(isLast(other))));
    this.advice = state.note.slice(about.length);
    if (document.activeElement !== this.note) this.note.value = about;
  }
}
