/**
 * The style as a whole: its main controls, variants, colours and note.
 *
 * @module
 */

import { make } from "./elements.js";
import { ValueList } from "./values.js";

/** @typedef {import("./types.js").State} State */

/** Shows the style itself. */
export class StylePanel {
  /** @param {import("./session.js").Session} session */
  constructor(session) {
    this.session = session;
    this.knobs = new ValueList(session, false);
    this.fields = new ValueList(session, true);
    this.note = make("textarea", { id: "note", rows: 4, maxLength: 2000, placeholder: "What this style looks like" });
    this.note.addEventListener("change", () => session.edit("note", { text: this.note.value }));
    this.variants = make("div", { className: "chips" });
    this.variants.setAttribute("role", "group");
    this.variants.setAttribute("aria-label", "Variants");
    this.none = make("p", { className: "quiet", textContent: "No main controls yet: pin a value of a step to have it here." });
    this.errors = make("div", { className: "error" });
    this.strength = make("input", { type: "range", min: "0", max: "1", step: "0.01", id: "strength" });
    this.strength.addEventListener("input", () => {
      this.#strength(Number(this.strength.value));
      session.setStrength(Number(this.strength.value));
    });
    this.strength.addEventListener("dblclick", () => session.setStrength(1));
    this.strengthValue = make("output");
    const top = make("div", { className: "top" }, make("label", { htmlFor: "strength", textContent: "Strength" }), this.strengthValue);
    const track = make("div", { className: "track" }, this.strength);
    track.style.setProperty("--default", "1");
    this.strengthBox = make("div", { className: "value" }, top, track,
      make("p", { className: "help", textContent: "How much of the original shows through: 0 is the original." }));
    this.more = make("details", {}, make("summary", { textContent: "Colours, size and note" }), this.fields.element,
      make("label", { htmlFor: "note", textContent: "Note", className: "above" }), this.note);
    this.about = make("p", { className: "about" });
    this.element = make("div", { className: "style-panel" }, this.errors, this.about, this.variants, this.none, this.knobs.element,
      this.strengthBox, this.more);
  }

  /** @param {State} state */
  show(state) {
    const [about] = state.note.split(" Tune ");
    this.about.textContent = about;
    this.errors.replaceChildren(...state.errors.map((text) => make("p", { textContent: text })));
    this.errors.hidden = !state.errors.length;
    this.variants.replaceChildren(...state.variants.map((name) => {
      const chip = make("button", { type: "button", textContent: name });
      chip.addEventListener("click", () => this.session.edit("variant", { name }));
      return chip;
    }));
    this.knobs.show(state.knobs);
    this.none.hidden = state.knobs.length > 0;
    this.fields.show(state.fields);
    if (document.activeElement !== this.note) this.note.value = state.note;
    this.strengthBox.hidden = state.strength === undefined;
    if (state.strength !== undefined && !this.session.isBusy("strength")) this.#strength(state.strength);
  }

  /** @param {number} value */
  #strength(value) {
    this.strength.value = String(value);
    this.strength.style.setProperty("--part", String(value));
    this.strengthValue.textContent = `${Math.round(100 * value)} %`;
  }
}
