// The comparison of starred looks: their pictures next to each other, each with its name, description and actions.

import { answer } from "./button_answer.js";
import { get, icon, make, press } from "./elements.js";
import { switchOriginal } from "./original_button.js";

/** The most looks that are compared at once. */
export const MAX_COMPARED = 6;
/** Height of what is below a picture, in CSS pixels; the distance between pictures; the narrowest picture. */
const [TEXT_PX, GAP_PX, MIN_WIDTH_PX] = [120, 16, 240];

/**
 * A look of the sheet.
 * @typedef {object} Look
 * @property {number} number
 * @property {string} name
 * @property {string} about
 * @property {string} picture its address
 */

/** Returns names as a list in words. @param {string[]} names */
export const listed = (names) => [names.slice(0, -1).join(", "), ...names.slice(-1)].filter(Boolean).join(" and ");

/**
 * Returns the number of columns in which the pictures are largest, and their width in CSS pixels.
 * @param {number} count @param {number} aspect of the pictures @param {number} width of all @param {number} height of all
 * @returns {[number, number]}
 */
function largest(count, aspect, width, height) {
  const tried = Array.from({ length: count }, (_, at) => at + 1).map((columns) => {
    const rows = Math.ceil(count / columns);
    const inRow = (width - (columns - 1) * GAP_PX) / columns;
    return /** @type {[number, number]} */ ([columns, Math.min(inRow, ((height - (rows - 1) * GAP_PX) / rows - TEXT_PX) * aspect)]);
  });
  const [columns, side] = tried.reduce((best, each) => (each[1] > best[1] ? each : best));
  return side >= Math.min(width, MIN_WIDTH_PX) ? [columns, side] : [1, width]; // a small window scrolls
}

/** The dialog that compares looks. */
export class Comparison {
  dialog = /** @type {HTMLDialogElement} */ (get("comparison"));
  /** @type {{look: Look, image: HTMLImageElement, tag: HTMLElement, star: HTMLElement}[]} */
  #panes = [];
  #isHeld = false;

  /**
   * @param {Look} original
   * @param {(number: number) => boolean} isStarred
   * @param {Record<"star" | "save" | "enlarge", (number: number) => void>} act
   */
  constructor(original, isStarred, act) {
    this.original = original;
    this.isStarred = isStarred;
    this.act = act;
    switchOriginal(get("compared-original"), () => this.#isHeld, (on) => this.hold(on));
    get("close-comparison").addEventListener("click", () => this.dialog.close());
    this.dialog.addEventListener("close", () => this.hold(false));
    addEventListener("resize", () => this.dialog.open && this.#arrange());
  }

  /** @param {Look[]} looks 2 to `MAX_COMPARED` */
  show(looks) {
    get("compared-names").textContent = listed(looks.map(({ name }) => name));
    this.#panes = [];
    get("compared").replaceChildren(...looks.map((look) => this.#pane(look)));
    this.mark();
    this.dialog.showModal();
    this.#arrange();
  }

  /** Shows the original in place of all looks. @param {boolean} on */
  hold(on) {
    this.#isHeld = on;
    press(get("compared-original"), on);
    for (const { look, image, tag } of this.#panes) {
      image.src = on ? this.original.picture : look.picture;
      tag.textContent = on ? `${look.name}: original` : look.name;
    }
  }

  /** Shows which looks are starred. */
  mark() {
    for (const { look, star } of this.#panes) {
      const on = this.isStarred(look.number);
      press(star, on);
      star.replaceChildren(icon("star"), on ? "Starred" : "Star");
    }
  }

  /** @param {Look} look */
  #pane(look) {
    const { number, name, about, picture } = look;
    const image = make("img", { src: picture, alt: name });
    const tag = make("span", { className: "tag", textContent: name });
    const star = make("button", { type: "button" });
    star.onclick = () => {
      this.act.star(number);
      this.mark();
    };
    const save = make("button", { type: "button", textContent: "Save picture" });
    save.onclick = () => {
      this.act.save(number);
      answer(save, "Saved");
    };
    this.#panes.push({ look, image, tag, star });
    return make("figure", {}, make("button", { type: "button", className: "enlarge", ariaLabel: `Enlarge ${name}`, onclick: () => this.act.enlarge(number) }, image, tag),
      make("p", { className: "quiet", textContent: about }), make("div", {}, star, save));
  }

  /** Makes the pictures as large as the window allows. */
  #arrange() {
    const place = get("compared"), { naturalWidth, naturalHeight } = this.#panes[0].image;
    const style = getComputedStyle(place);
    const [width, height] = [place.clientWidth - 2 * parseFloat(style.paddingLeft), place.clientHeight - 2 * parseFloat(style.paddingTop)];
    const [columns, side] = largest(this.#panes.length, naturalWidth / (naturalHeight || 1) || 1, width, height);
    place.style.gridTemplateColumns = `repeat(${columns}, ${Math.floor(side)}px)`;
  }
}
