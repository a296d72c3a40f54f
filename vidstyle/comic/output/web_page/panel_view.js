// Reading panel by panel: one panel fills the window.

import { get, icon, makeSvg } from "./elements.js";
import { reducePictures } from "./fine_pictures.js";
import { SHARED_KEYS } from "./shared_keys.js";

/** Returns x, y, width and height of a panel on its page, wherever it was moved. @param {SVGGElement} panel */
function placeOf(panel) {
  const { x, y, width, height } = panel.getBBox();
  const { a, d, e, f } = panel.transform.baseVal.consolidate()?.matrix ?? { a: 1, d: 1, e: 0, f: 0 };
  return [a * x + e, d * y + f, a * width, d * height];
}

/** Windows that are as narrow as a phone: panels stand one below the other. */
export const NARROW = matchMedia("(max-width: 40rem)");
/** An enlarged panel is whole if it then is larger than on the page by the first factor, else larger by the second. */
const [ENOUGH_GAIN, PART_GAIN] = [1.4, 2];

/** A pointer that has moved so far is no click, and one that has moved farther turns to another panel. */
const [MIN_DRAG_PX, MIN_SWIPE_PX] = [8, 40];

/** Enlarges panels when they are clicked, or when Enter is pressed. */
export class PanelView {
  #at = 0;
  /** Whether panels are shown whole where parts of them would be larger. */
  #isWhole = true;
  #dialog = /** @type {HTMLDialogElement} */ (get("reading"));

  #view = get("panel-picture");
  /** Where a finger or the mouse was pressed, and how far the panel was scrolled then. @type {{x: number, y: number, left: number, top: number} | null} */
  #pressed = null;

  /**
   * @param {SVGGElement[]} panels in reading order
   * @param {() => void} onclose is called when the page is seen again
   */
  constructor(panels, onclose) {
    this.panels = panels;
    panels.forEach((panel, number) => this.#prepare(panel, number));
    for (const [id, by, name] of /** @type {const} */ ([["panel-before", -1, "back"], ["panel-after", 1, "forward"]])) {
      get(id).prepend(icon(name));
      get(id).addEventListener("click", () => this.#show(this.#at + by));
    }
    get("read").prepend(icon("enlarge"));
    if (panels.length < 2) {
      get("read-label").textContent = "Enlarge";
      get("read").title = "Enlarge the panel: click it, or press Enter";
      for (const id of ["panel-before", "panel-after", "panel-number"]) get(id).hidden = true;
    }
    get("read").addEventListener("click", () => this.#open(this.#at));
    get("panel-whole").addEventListener("click", () => {
      this.#isWhole = !this.#isWhole;
      this.refresh();
    });
    get("panel-close").prepend(icon("close"));
    get("panel-close").addEventListener("click", () => this.#dialog.close());
    this.#view.addEventListener("pointerdown", (event) => this.#press(event));
    this.#view.addEventListener("pointermove", (event) => this.#drag(event));
    this.#view.addEventListener("pointerup", (event) => this.#release(event));
    this.#view.addEventListener("pointercancel", () => (this.#pressed = null));
    addEventListener("resize", () => this.refresh());
    this.#dialog.addEventListener("close", () => {
      this.panels[this.#at].focus();
      onclose();
    });
    this.#dialog.addEventListener("keydown", (event) => this.#key(event));
  }

  get isOpen() {
    return this.#dialog.open;
  }

  /** @param {SVGGElement} panel @param {number} number */
  #prepare(panel, number) {
    const note = panel.querySelector(":scope > title")?.textContent;
    const hasParts = panel.querySelector("[data-place]");
    panel.tabIndex = 0;
    panel.setAttribute("role", hasParts ? "group" : "button");
    panel.setAttribute("aria-label", `Panel ${number + 1} of ${this.panels.length}${note ? `, ${note}` : ""}. Enter enlarges it.`);
    panel.classList.add("panel");
    panel.addEventListener("click", () => document.body.matches(".editing") || this.#open(number));
    panel.addEventListener("keydown", (event) => {
      if (event.target !== panel || document.body.matches(".editing") || (event.key !== "Enter" && event.key !== " ")) return;
      event.preventDefault();
      this.#open(number);
    });
  }

  /** @param {number} number */
  #open(number) {
    this.#isWhole = true; // no head is cut until a larger part is asked for
    this.#dialog.showModal();
    this.#show(number);
  }

  /** @param {PointerEvent} event */
  #press({ clientX: x, clientY: y, isPrimary, button, pointerId }) {
    if (!isPrimary || button) return;
    const { scrollLeft: left, scrollTop: top } = this.#view;
    this.#pressed = { x, y, left, top };
    this.#view.setPointerCapture(pointerId);
  }

  /** Moves a panel that is larger than the window. @param {PointerEvent} event */
  #drag({ clientX, clientY }) {
    if (!this.#pressed) return;
    const { x, y, left, top } = this.#pressed;
    this.#view.scrollTo(left + x - clientX, top + y - clientY);
  }

  /** Turns to the side of a click, or against the direction of a swipe that starts at the edge of the panel. @param {PointerEvent} event */
  #release({ clientX, clientY }) {
    if (!this.#pressed) return;
    const { x, y, left } = this.#pressed;
    this.#pressed = null;
    const moved = clientX - x;
    const isAtEdge = moved > 0 ? left <= 1 : left >= this.#view.scrollWidth - this.#view.clientWidth - 1;
    if (Math.hypot(moved, clientY - y) < MIN_DRAG_PX) this.#show(this.#at + (clientX < innerWidth / 2 ? -1 : 1));
    else if (Math.abs(moved) > MIN_SWIPE_PX && isAtEdge) this.#show(this.#at + (moved > 0 ? -1 : 1));
  }

  /** Shows the enlarged panel again, after the panels were placed differently. */
  refresh() {
    if (this.isOpen) this.#show(this.#at);
  }

  /** Shows a panel, if there is one of this number. @param {number} number */
  #show(number) {
    const panel = this.panels[number];
    if (!panel) return;
    this.#at = number;
    const [x, y, width, height] = placeOf(panel);
    const whole = /** @type {SVGSVGElement} */ (makeSvg("svg", { viewBox: `${x} ${y} ${width} ${height}`, "font-family": panel.ownerSVGElement?.getAttribute("font-family") ?? "" }));
    whole.append(makeSvg("use", { href: `#${panel.id}` }));
    this.#view.replaceChildren(whole);
    this.#fit(whole, width, height, panel.ownerSVGElement?.getScreenCTM()?.a ?? 1);
    const own = panel.transform.baseVal.consolidate()?.matrix.a ?? 1;
    reducePictures(panel, own * (whole.getScreenCTM()?.a ?? 1) * devicePixelRatio);
    get("panel-number").textContent = `${number + 1} of ${this.panels.length}`;
    get("panel-note").textContent = panel.querySelector(":scope > title")?.textContent ?? "";
    for (const [id, by] of /** @type {const} */ ([["panel-before", -1], ["panel-after", 1]])) get(id).toggleAttribute("disabled", !this.panels[number + by]);
  }

  /** Gives an enlarged panel its size, and shows its middle. @param {SVGSVGElement} whole @param {number} width @param {number} height @param {number} scale of the page */
  #fit(whole, width, height, scale) {
    this.#view.classList.remove("part");
    const { paddingLeft, paddingTop } = getComputedStyle(this.#view);
    const ratios = [(this.#view.clientWidth - 2 * parseFloat(paddingLeft)) / width, (this.#view.clientHeight - 2 * parseFloat(paddingTop)) / height];
    const [fitting, filling] = [Math.min(...ratios), Math.max(...ratios)];
    const larger = fitting >= ENOUGH_GAIN * scale ? fitting : Math.max(fitting, Math.min(filling, PART_GAIN * scale));
    const shown = this.#isWhole ? fitting : larger;
    Object.assign(whole.style, { width: `${shown * width}px`, height: `${shown * height}px` });
    get("panel-whole").hidden = larger === fitting;
    get("panel-whole").replaceChildren(icon(this.#isWhole ? "enlarge" : "fit"), this.#isWhole ? "Larger" : "Fit");
    get("panel-whole").title = this.#isWhole ? "Enlarge the panel beyond the window; drag to move it" : "Fit the whole panel into the window";
    this.#view.classList.toggle("part", shown > fitting);
    // A part can be scrolled with the arrow keys, too.
    this.#view.tabIndex = shown > fitting ? 0 : -1;
    this.#view.scrollTo((this.#view.scrollWidth - this.#view.clientWidth) / 2, (this.#view.scrollHeight - this.#view.clientHeight) / 2);
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (event.target === this.#view && event.key.startsWith("Arrow") && this.#view.classList.contains("part")) return;
    const last = this.panels.length - 1;
    if (event.key === SHARED_KEYS.help) /** @type {HTMLDialogElement} */ (get("help")).showModal();
    const next = { ArrowLeft: this.#at - 1, ArrowRight: this.#at + 1, Home: 0, End: last, [SHARED_KEYS.next]: this.#at + 1 }[event.key];
    if (next === undefined && event.key !== SHARED_KEYS.zoom) return;
    event.preventDefault();
    event.stopPropagation();
    if (next === undefined) this.#dialog.close();
    else this.#show(next);
  }
}
