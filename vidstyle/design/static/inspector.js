// The inspector: parameters, actions and connections of the selected step.

import { icon, make, press, words } from "./elements.js";
import { LAYER_NAMES, nameOf, placeOf } from "./types.js";
import { ValueList } from "./values.js";

/** @typedef {import("./types.js").Step} Step */
/** @typedef {import("./types.js").State} State */

/** @typedef {"mute" | "solo" | "copy" | "duplicate" | "remove" | "expand"} Action the action of a button on the step */

/** Shows one step. */
export class Inspector {
  /** @type {Step | null} */
  step = null;

  /**
   * @param {import("./session.js").Session} session
   * @param {(action: Action) => void} act
   */
  constructor(session, act) {
    this.session = session;
    this.values = new ValueList(session, true);
    this.name = make("h2");
    this.kind = make("p", { className: "quiet" });
    this.help = make("p", { className: "about" });
    this.error = make("p", { className: "error" });
    this.error.setAttribute("role", "alert");
    /** @type {Map<Action, HTMLButtonElement>} */
    this.buttons = new Map();
    const buttons = make("div", { className: "actions" });
    /** The words on the buttons that change what the picture shows. @type {Partial<Record<Action, string>>} */
    const shownWords = { mute: "Mute", solo: "Solo" };
    for (const [action, drawing, label, key] of /** @type {[Action, string, string, string][]} */ ([
      ["mute", "mute", "Mute: pass the picture through unchanged", "M"], ["solo", "solo", "Solo: show the output of this step", "O"],
      ["copy", "clipboard", "Copy, to paste it into any style", "Ctrl C"], ["duplicate", "copy", "Duplicate", "D"], ["expand", "expand", "Replace with the steps that it is made of", "E"],
      ["remove", "remove", "Remove", "Del"],
    ])) {
      const button = make("button", { className: "plain", type: "button", title: `${label} (${key})` }, icon(drawing), shownWords[action] ?? "");
      button.setAttribute("aria-label", label.split(":")[0]);
      button.addEventListener("click", () => act(action));
      this.buttons.set(action, button);
      buttons.append(button);
    }
    this.from = make("select", { id: "from" });
    this.save = make("input", { id: "save-as", type: "text", maxLength: 64, pattern: "[A-Za-z_][A-Za-z0-9_-]*", placeholder: "not saved" });
    const links = make("details", { className: "links" }, make("summary", { textContent: "Connections" }),
      make("div", { className: "pair" }, make("label", { htmlFor: "from", textContent: "Input" }), this.from),
      make("div", { className: "pair" }, make("label", { htmlFor: "save-as", textContent: "Save output as" }), this.save),
      make("p", { className: "help", textContent: "Later steps can use a saved picture as input or blend with it." }));
    this.links = links;
    this.example = make("details", { className: "example" }, make("summary", { textContent: "What this block does" }));
    this.example.addEventListener("toggle", () => this.#showExample());
    this.element = make("div", { className: "inspector" }, make("header", {}, this.name, this.kind), buttons,
      this.error, this.help, this.values.element, this.example, links);
    this.from.addEventListener("change", () => this.#refer("from", this.from.value));
    this.save.addEventListener("change", () => this.save.reportValidity() && this.#refer("save", this.save.value.trim()));
  }

  /** @param {"from" | "save"} name @param {string} value */
  #refer(name, value) {
    if (this.step) this.session.edit("refer", { step: this.step.step, name, value });
  }

  /**
   * @param {State} state
   * @param {Step} step
   * @param {boolean} solo
   */
  show(state, step, solo) {
    const other = this.step?.step !== step.step;
    this.step = step;
    const place = placeOf(state, step.step);
    this.name.textContent = nameOf(step);
    this.kind.textContent = place ? `Step ${place.index + 1} of ${state.layers[place.layer].length} in ${LAYER_NAMES[place.layer]}` : "";
    this.kind.title = place && step.block ? `In style files: ${step.block} in [[${place.layer}]]` : "";
    this.help.textContent = step.help;
    this.error.textContent = step.error ?? "";
    this.error.hidden = !step.error;
    press(this.buttons.get("mute"), step.muted);
    press(this.buttons.get("solo"), solo);
    const expand = this.buttons.get("expand");
    if (expand) expand.hidden = !step.recipe;
    this.values.show(step.entries);
    this.example.hidden = !step.block;
    this.#showExample();
    this.#links(step, other);
  }

  /** Shows an example before and after the block, once that is asked for. */
  #showExample() {
    const block = this.step?.block;
    if (!block || !this.example.open || this.example.dataset.picture === this.session.sampleAt(block)) return;
    this.example.dataset.picture = this.session.sampleAt(block);
    const figures = Object.entries({ source: "Before", [block]: "After, with default values" }).map(([name, text]) =>
      make("figure", {}, make("img", { src: this.session.sampleAt(name), alt: "" }), make("figcaption", { textContent: text })));
    const explanation = this.session.blocks.find(({ name }) => name === block)?.explanation ?? "";
    this.example.replaceChildren(this.example.children[0], make("div", {}, ...figures), make("p", { className: "help", textContent: explanation }));
  }

  /** @param {Step} step @param {boolean} other whether the step is not the one shown before */
  #links(step, other) {
    if (other) this.links.open = Boolean(step.from || step.save);
    const options = [...new Set([...step.from_options, step.from])];
    if ([...this.from.options].map(({ value }) => value).join() !== options.join())
      this.from.replaceChildren(...options.map((name) => new Option(name ? words(name) : "previous step", name)));
    this.from.value = step.from;
    this.save.placeholder = step.implied ? `not saved by name; saved as ${step.implied}` : "not saved";
    if (document.activeElement !== this.save) this.save.value = step.save;
  }
}
