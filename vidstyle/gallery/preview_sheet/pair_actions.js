// The actions below each of two looks that are compared.

import { answer } from "./button_answer.js";
import { icon, make, press } from "./elements.js";

const SAVE = "Save picture";

/** Buttons for one of two looks: star, save, use. */
export class PairActions {
  #word = make("span");
  #star = make("button", { type: "button" }, icon("star"), this.#word);

  /** @param {HTMLImageElement} picture above them @param {() => number} number of the look @param {Record<"star" | "save" | "use", (number: number) => void>} act */
  constructor(picture, number, act) {
    this.number = number;
    this.#star.onclick = () => act.star(number());
    const save = make("button", { type: "button", textContent: SAVE });
    save.onclick = () => {
      act.save(number());
      answer(save, "Saved", SAVE);
    };
    const use = make("button", { type: "button", textContent: "Use this look", onclick: () => act.use(number()) });
    picture.parentElement?.append(make("div", { className: "pair-actions" }, this.#star, save, use));
  }

  /** Shows whether the look is starred. @param {boolean} isStarred */
  show(isStarred) {
    press(this.#star, isStarred);
    this.#word.textContent = isStarred ? "Starred" : "Star";
  }
}
