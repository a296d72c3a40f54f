// Reading panel by panel: one panel fills the window.

import { get, icon, makeSvg, press } from "./elements.js";
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
/** Turning an enlarged panel is offered if it then is larger by this factor. */
const MIN_TURN_GAIN = 1.25;

/** Whether a panel is larger on its side, as on a phone. @param {number} width @param {number} height of the panel */
function gainsByTurning(width, height) {
  const { clientWidth, clientHeight } = get("panel-picture");
  const upright = Math.min(clientWidth / width, clientHeight / height);
  return Math.min(clientWidth / height, clientHeight / width) > MIN_TURN_GAIN * upright;
}

/** A finger that has moved so far turns to another panel. */
const MIN_SWIPE_PX = 40;

/** Enlarges panels when they are clicked, or when Enter is pressed. */
export class PanelView {
  #at = 0;
  /** Whether panels are shown on their side, where they are larger so. */
  #isTurned = false;
  #dialog = /** @type {HTMLDialogElement} */ (get("reading"));

  /** The place where a finger or the mouse was pressed. */
  #pressed = 0;

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
    get("read").addEventListener("click", () => this.#open(this.#at));
    get("panel-turn").prepend(icon("turn"));
    get("panel-turn").addEventListener("click", () => {
      this.#isTurned = !this.#isTurned;
      this.refresh();
    });
    get("panel-close").prepend(icon("close"));
    get("panel-close").addEventListener("click", () => this.#dialog.close());
    get("panel-picture").addEventListener("pointerdown", ({ clientX, isPrimary }) => isPrimary && (this.#pressed = clientX));
    get("panel-picture").addEventListener("pointerup", ({ clientX, isPrimary, button }) => isPrimary && !button && this.#turn(clientX));
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
    panel.addEventListener("click", ({ target }) => /** @type {Element} */ (target).closest("[data-place]") || this.#open(number));
    panel.addEventListener("keydown", (event) => {
      if (event.target !== panel || (event.key !== "Enter" && event.key !== " ")) return;
      event.preventDefault();
      this.#open(number);
    });
  }

  /** @param {number} number */
  #open(number) {
    this.#dialog.showModal();
    this.#show(number);
  }

  /** Turns to the side of a click, or against the direction of a swipe. @param {number} x where the pointer was released */
  #turn(x) {
    const moved = x - this.#pressed;
    const isBack = Math.abs(moved) > MIN_SWIPE_PX ? moved > 0 : x < innerWidth / 2;
    this.#show(this.#at + (isBack ? -1 : 1));
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
    const gains = NARROW.matches && gainsByTurning(width, height);
    const turned = gains && this.#isTurned;
    get("panel-turn").hidden = !gains;
    press(get("panel-turn"), turned);
    const viewBox = turned ? `0 0 ${height} ${width}` : `${x} ${y} ${width} ${height}`;
    const whole = /** @type {SVGSVGElement} */ (makeSvg("svg", { viewBox, "font-family": panel.ownerSVGElement?.getAttribute("font-family") ?? "" }));
    whole.append(makeSvg("use", { href: `#${panel.id}`, ...(turned && { transform: `rotate(90) translate(${-x} ${-y - height})` }) }));
    get("panel-picture").replaceChildren(whole);
    const own = panel.transform.baseVal.consolidate()?.matrix.a ?? 1;
    reducePictures(panel, own * (whole.getScreenCTM()?.a ?? 1) * devicePixelRatio);
    get("panel-number").textContent = `${number + 1} of ${this.panels.length}`;
    get("panel-note").textContent = panel.querySelector(":scope > title")?.textContent ?? "";
    for (const [id, by] of /** @type {const} */ ([["panel-before", -1], ["panel-after", 1]])) get(id).toggleAttribute("disabled", !this.panels[number + by]);
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
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
