// Copying and pasting of steps, between styles, tabs and windows. In the clipboard they are text, as in a style file.

import { LAYER_NAMES, nameOf } from "./types.js";

/** The key under which this browser keeps what was copied, for pasting by mouse. */
const KEPT = "steps";

/** Copies and pastes steps. */
export class Clipboard {
  /** @param {import("./session.js").Session} session @param {import("./steps.js").Steps} steps @param {(text: string) => void} say */
  constructor(session, steps, say) {
    this.session = session;
    this.steps = steps;
    this.say = say;
    addEventListener("paste", (event) => this.#pasted(event));
  }

  /** Copies the selected step. @param {boolean} whole whether to copy all steps of its layer */
  async copy(whole) {
    const { step } = this.steps;
    const answer = step && (await this.session.ask("copied", { step: step.step, whole }));
    if (!step || !answer) return;
    localStorage.setItem(KEPT, answer.text);
    await navigator.clipboard?.writeText(answer.text).catch(() => {});
    this.say(`${whole ? "All steps of the layer" : nameOf(step)} copied. Paste into this or another style.`);
  }

  /** What was copied in this browser; "" for nothing. */
  get kept() {
    return localStorage.getItem(KEPT) ?? "";
  }

  /** Adds what was copied. @param {string} text @param {import("./types.js").Layer} layer @param {number} index */
  async paste(text, layer, index) {
    const answer = await this.session.edit("paste", { layer, index, text });
    if (answer?.step === undefined) return;
    this.steps.select(answer.step);
    this.say(`Pasted into ${LAYER_NAMES[layer]}, position ${index + 1}.`);
  }

  /** @param {ClipboardEvent} event */
  #pasted(event) {
    const target = /** @type {Element} */ (event.target);
    const text = event.clipboardData?.getData("text/plain");
    const place = this.steps.placeAfter;
    if (!text || !place || target.matches("input, textarea") || !document.body.classList.contains("building")) return;
    event.preventDefault();
    this.paste(text, place.layer, place.index);
  }
}
