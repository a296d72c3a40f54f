// What the next nine looks keep of the chosen one, and how much they differ from it.

import { get, make, makeSvg, press } from "./elements.js";

/** The parts of a look that can be kept. @type {Record<string, string>} */
const LOCK_LABELS = { lines: "Lines", background: "Background", colors: "Colours", steps: "Filters" };

/** The controls of the next nine. */
export class NextNine {
  #near = /** @type {HTMLInputElement} */ (get("near"));

  /**
   * @param {(kind: string, fields: object) => Promise<any>} ask
   * @param {(text: string) => void} say
   */
  constructor(ask, say) {
    this.ask = ask;
    this.say = say;
    get("locks").append(...Object.keys(LOCK_LABELS).map((name) => this.#lock(name)));
    this.#near.addEventListener("change", () => this.#send("near", { part: Number(this.#near.value) }));
  }

  /** @param {import("./explore_types.js").State} state */
  show({ near, locks }) {
    this.#near.value = String(near);
    for (const name of Object.keys(LOCK_LABELS)) press(get(`lock-${name}`), locks.includes(name));
  }

  /** @param {string} kind @param {object} fields */
  #send(kind, fields) {
    this.ask(kind, fields).catch((error) => this.say(error.message));
  }

  /** Returns the button that keeps a part. @param {string} name */
  #lock(name) {
    const label = LOCK_LABELS[name];
    const sign = makeSvg("svg", { viewBox: "0 0 16 16", "aria-hidden": "true" });
    sign.append(makeSvg("path", { class: "shut", d: "M3.5 7.5h9v6h-9zM5.5 7.5v-2a2.5 2.5 0 0 1 5 0v2" }), makeSvg("path", { class: "open", d: "M3.5 7.5h9v6h-9zM5.5 7.5v-2a2.5 2.5 0 0 1 4.800-1" }));
    const button = make("button", { id: `lock-${name}`, title: `The next nine keep the ${label.toLowerCase()} of the look that you choose` }, sign, label);
    press(button, false);
    button.onclick = () => {
      const on = button.ariaPressed !== "true";
      press(button, on);
      this.#send("lock", { name, on });
      this.say(on ? `The next nine keep the ${label.toLowerCase()} of the look that you choose.` : `The ${label.toLowerCase()} may change again.`);
    };
    return button;
  }
}
