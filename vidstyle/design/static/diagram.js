// The diagram: a card for each step, wires between the cards, and a button on each wire that adds a step.

import { get, icon, make, makeSvg } from "./elements.js";
import { fold, purposeOf } from "./fold.js";
import { layoutOf, pathOf } from "./layout.js";
import { LAYER_NAMES, nameOf, placeOf, stepsOf } from "./types.js";
import { enableDragging } from "./drag.js";

/** @typedef {import("./layout.js").CardName} CardName */
/** @typedef {import("./layout.js").Layout} Layout */
/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").Step} Step */
/** @typedef {import("./types.js").Layer} Layer */

/**
 * @typedef {object} Actions
 * @property {(name: CardName) => void} select
 * @property {(layer: Layer, index: number, near: DOMRect) => void} add
 * @property {(step: number, layer: Layer, index: number) => void} move
 * @property {() => void} showBehindLines
 */

/** Number of colours for the wires of saved pictures. */
const COLOR_COUNT = 6;
/** Height of the legend below the cards, as in the style sheet. */
const LEGEND_PX = 28;
/** Duration of the animation that moves cards. */
const MOVING_MS = 180;

/** Returns what wires mean. @param {State} state */
const wiresOf = ({ edges }) => [" Grey wires: the picture.", edges.length && "Coloured wires: a second input or a mask."].filter(Boolean).join(" ");

/** Whether lines are on plain paper, which hides the picture, in a style whose author has not pinned values yet. @param {State} state */
const isOnPaper = ({ layers, knobs }) => layers.lines.length > 0 && !layers.background.length && !knobs.length;

/** Draws the state of a style as cards. */
export class Diagram {
  /** @type {Layout | null} */
  layout = null;
  /** @type {CardName | null} */
  selected = null;
  /** Whether all steps are shown, also those that make pictures for others. */
  isWhole = false;
  /** The soloed step. @type {number | null} */
  solo = null;
  /** The size of the film, as text. */
  film = "";
  /** @type {State | null} */
  state = null;
  /** @type {Map<CardName, HTMLButtonElement>} */
  #cards = new Map();
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #moving;
  /** Thumbnail URLs by step. @type {Map<number, string>} */
  #pictures = new Map();

  /** @param {Actions} actions @param {() => number} maxHeight returns the maximum height, in CSS pixels */
  constructor(actions, maxHeight) {
    this.actions = actions;
    this.maxHeight = maxHeight;
    this.root = get("diagram");
    this.area = get("cards");
    this.wires = /** @type {SVGSVGElement} */ (/** @type {unknown} */ (get("wires")));
    this.whole = make("button", { className: "whole plain", type: "button", onclick: () => this.#toggleWhole() });
    this.wireLegend = make("span");
    this.legend = make("p", { className: "legend quiet", textContent: "Prepare comes first. Then Lines are drawn over Colour." });
    this.legend.append(this.wireLegend);
    const behind = make("button", { type: "button", textContent: "Put the picture behind the lines", onclick: () => actions.showBehindLines() });
    this.paper = make("p", { className: "paper", role: "status" }, make("span", { textContent: "Lines are on plain paper: Colour has no steps." }), behind);
    this.root.append(this.paper, this.legend, this.whole);
    new ResizeObserver(() => requestAnimationFrame(() => this.arrange())).observe(this.root);
    enableDragging(this);
  }

  /** @param {State} state */
  show(state) {
    this.state = state;
    const steps = new Map(stepsOf(state).map((step) => [/** @type {CardName} */ (step.step), step]));
    for (const [name, card] of this.#cards)
      if ((typeof name === "number" && !steps.has(name)) || (typeof name === "string" && name.startsWith("fold-"))) {
        card.remove();
        this.#cards.delete(name);
        this.#discardPicture(name);
      }
    this.#write(this.#card("source"), "Source", this.film);
    for (const [name, step] of steps) this.#fill(this.#card(name), /** @type {Step} */ (step));
    const { background, lines } = state.layers;
    const end = this.#card("result");
    this.#write(end, "Result", lines.length ? (background.length ? "ink over colour" : "ink on paper") : "");
    this.wireLegend.textContent = wiresOf(state);
    this.paper.hidden = !isOnPaper(state);
    this.legend.hidden = !this.paper.hidden;
    this.area.classList.add("moving");
    clearTimeout(this.#moving);
    this.#moving = setTimeout(() => this.area.classList.remove("moving"), MOVING_MS);
    this.arrange();
    this.mark();
  }

  /** @param {CardName} name */
  #card(name) {
    const known = this.#cards.get(name);
    if (known) return known;
    const picture = name !== "source" && name !== "result" ? make("img", { alt: "", draggable: false }) : make("canvas", { width: 320, height: 180 });
    const card = make("button", { className: "card", type: "button", tabIndex: -1 }, picture,
      make("span", { className: "badges" }), make("span", { className: "name" }), " ", make("span", { className: "main" }));
    card.dataset.card = String(name);
    card.id = `card-${name}`;
    card.addEventListener("click", () => this.actions.select(this.#stepOf(name)));
    card.addEventListener("pointerenter", () => this.#highlight(name));
    card.addEventListener("pointerleave", () => this.#highlight(this.selected));
    this.#cards.set(name, card);
    return card;
  }

  /** Returns the first step of a fold, which opens it; other names as they are. @param {CardName} name @returns {CardName} */
  #stepOf(name) {
    return typeof name === "string" && name.startsWith("fold-") ? Number(name.slice("fold-".length)) : name;
  }

  /** @param {HTMLElement} card @param {string} name @param {string} main */
  #write(card, name, main) {
    const [label, value] = [card.querySelector(".name"), card.querySelector(".main")];
    if (label && label.textContent !== name) label.textContent = name;
    if (value && value.textContent !== main) value.textContent = main;
  }

  /** @param {HTMLButtonElement} card @param {Step} step */
  #fill(card, step) {
    this.#write(card, nameOf(step), step.main);
    card.classList.toggle("muted", step.muted);
    card.classList.toggle("wrong", Boolean(step.error));
    this.#mark(/** @type {HTMLElement} */ (card.querySelector(".badges")), step);
    const place = placeOf(/** @type {State} */ (this.state), step.step);
    const facts = [nameOf(step), step.main, LAYER_NAMES[place?.layer ?? "base"], step.muted && "muted",
      step.save && `saved as ${step.save}`, step.from && `from ${step.from}`, step.error && `error: ${step.error}`];
    card.setAttribute("aria-label", facts.filter(Boolean).join(", "));
    card.title = step.error ?? step.help;
  }

  /** Shows the badges of a step, unless they are the same as before. @param {HTMLElement} badges @param {Step} step */
  #mark(badges, step) {
    const shown = JSON.stringify([step.error, step.muted, this.solo === step.step, step.save, step.save && this.#color(step.save)]);
    if (badges.dataset.shown === shown) return;
    badges.dataset.shown = shown;
    const marks = [];
    if (step.error) marks.push(make("span", { className: "badge wrong", title: step.error }, icon("warning")));
    if (step.muted) marks.push(make("span", { className: "badge", title: "Muted" }, icon("mute")));
    if (this.solo === step.step) marks.push(make("span", { className: "badge solo", title: "Solo: the picture shows the output of this step" }, icon("solo")));
    if (step.save) {
      marks.push(make("span", { className: `badge save wire-${this.#color(step.save)}`, title: `Other steps use this picture, as “${step.save}”` }));
    }
    badges.replaceChildren(...marks);
  }

  /** Returns the colour number of a saved picture, in order of first appearance. @param {string} name */
  #color(name) {
    const names = [...new Set((this.state?.edges ?? []).map((edge) => edge.name))];
    return Math.max(0, names.indexOf(name)) % COLOR_COUNT;
  }

  /** Lays out the diagram for the current size. */
  arrange() {
    if (!this.state || !this.root.clientWidth) return;
    const folded = fold(this.state, this.selected, this.isWhole);
    const layout = layoutOf(folded, this.root.clientWidth, this.maxHeight() - LEGEND_PX);
    this.#showFolds(folded);
    this.layout = layout;
    document.documentElement.style.setProperty("--content", `${layout.height + LEGEND_PX}px`);
    this.root.dataset.size = layout.size.name;
    const width = Math.max(layout.width, this.root.clientWidth);
    for (const part of [this.area, this.wires]) {
      part.style.width = `${width}px`;
      part.style.height = `${layout.height}px`;
    }
    const shown = new Set(layout.cards.map(({ name }) => name));
    for (const [name, card] of this.#cards) if (!shown.has(name)) card.remove();
    for (const { name, x, y } of layout.cards) {
      const card = /** @type {HTMLButtonElement} */ (this.#cards.get(name));
      Object.assign(card.style, { translate: `${x}px ${y}px`, width: `${layout.size.w}px`, height: `${layout.size.h}px` });
      if (!card.isConnected) this.area.append(card); // only now, else it would move in from the corner
    }
    this.area.setAttribute("aria-owns", layout.cards.map(({ name }) => `card-${name}`).join(" "));
    const wires = [...layout.wires].sort((one, other) => Number(one.used) - Number(other.used));
    this.wires.replaceChildren(...wires.flatMap((wire) => this.#wire(wire)));
    this.area.querySelectorAll(".layer").forEach((old) => old.remove());
    for (const { layer, x, y } of layout.labels) {
      const label = make("span", { className: "layer", textContent: LAYER_NAMES[layer] });
      label.style.translate = `${x}px ${y}px`;
      this.area.append(label);
    }
    /** @type {Set<Element>} */
    const gaps = new Set(layout.gaps.map((gap) => this.#gap(gap)));
    this.area.querySelectorAll(".gap").forEach((old) => gaps.has(old) || old.remove());
  }

  /** Fills the cards of folds, and the button that opens all. @param {import("./fold.js").Folded} folded */
  #showFolds(folded) {
    const folds = Object.values(folded.items).flat().filter(({ steps }) => steps.length > 1);
    for (const each of folds) {
      const { step, steps } = each;
      const [card, name, purpose] = [this.#card(step), `${steps.length} helper steps`, purposeOf(folded, each)];
      card.classList.add("fold");
      card.title = `${steps.map(nameOf).join(", ")}: open to edit`;
      this.#write(card, name, purpose);
      card.setAttribute("aria-label", `${name} ${purpose}, folded: ${steps.map(nameOf).join(", ")}`);
      card.dataset.last = String(steps[steps.length - 1].step);
      const address = this.#pictures.get(steps[steps.length - 1].step);
      if (address) /** @type {HTMLImageElement} */ (card.firstElementChild).src = address;
    }
    this.whole.hidden = !folds.length && !this.isWhole;
    this.whole.textContent = this.isWhole ? "Fold helper steps" : "Show all steps";
  }

  #toggleWhole() {
    this.isWhole = !this.isWhole;
    this.arrange();
    this.mark();
  }

  /** @param {import("./layout.js").Wire} wire */
  #wire({ points, saved, used, from, to }) {
    const kind = saved ? `saved wire-${this.#color(saved)}` : "chain";
    const path = makeSvg("path", { d: pathOf(points, saved ? 5 : 9), class: `${kind}${used ? "" : " unused"}` });
    if (!saved) return [path];
    path.setAttribute("data-ends", `${from} ${to}`);
    const [x, y] = points[points.length - 1];
    const up = points[points.length - 2][1] > y ? 1 : -1;
    const head = makeSvg("path", { d: `M${x - 3.5} ${y + 6 * up} L${x} ${y + up} L${x + 3.5} ${y + 6 * up}z`, class: `head wire-${this.#color(saved)}` });
    head.setAttribute("data-ends", `${from} ${to}`);
    return [path, head];
  }

  /**
   * Returns the button of a gap. Buttons are reused when the diagram is remakeSvg, else a click in progress would be lost.
   * @param {import("./layout.js").Gap} gap
   */
  #gap({ layer, index, x, y }) {
    const old = this.area.querySelector(`.gap[data-layer=${layer}][data-index="${index}"]`);
    const button = /** @type {HTMLButtonElement} */ (old ?? this.#newGap(layer, index));
    if (this.state?.layers[layer].length) delete button.dataset.card;
    else button.dataset.card = layer;
    button.style.translate = `${x}px ${y}px`;
    return button;
  }

  /** @param {import("./types.js").Layer} layer @param {number} index */
  #newGap(layer, index) {
    const label = `Add a step to ${LAYER_NAMES[layer]}, position ${index + 1}`;
    const button = make("button", { className: "gap", type: "button", tabIndex: -1, title: "Add a step here" }, icon("plus"));
    button.setAttribute("aria-label", label);
    Object.assign(button.dataset, { layer, index });
    button.addEventListener("click", () => this.actions.add(layer, index, button.getBoundingClientRect()));
    this.area.append(button);
    return button;
  }

  /** Marks the selected card. */
  mark() {
    if (this.state && this.layout && !this.layout.cards.some(({ name }) => name === this.selected)) this.arrange();
    const reachable = this.selected !== null && this.#cards.has(this.selected) ? this.selected : "source";
    for (const [name, card] of this.#cards) {
      card.classList.toggle("selected", name === this.selected);
      card.toggleAttribute("aria-current", name === this.selected);
      card.tabIndex = name === reachable ? 0 : -1;
    }
    this.#highlight(this.selected);
  }

  /** Highlights the wires of saved pictures from and to a card. @param {CardName | null} name */
  #highlight(name) {
    for (const path of this.wires.querySelectorAll("[data-ends]")) {
      const ends = String(path.getAttribute("data-ends")).split(" ");
      path.classList.toggle("bright", name !== null && ends.includes(String(name)));
    }
  }

  /** @param {CardName} name */
  focus(name) {
    const card = this.#cards.get(name) ?? /** @type {HTMLElement | null} */ (this.area.querySelector(`.gap[data-layer=${name}]`));
    card?.focus({ preventScroll: true });
    card?.scrollIntoView({ block: "nearest", inline: "nearest" });
  }

  /** Returns the neighbour of a card in the direction of an arrow key. @param {CardName} name @param {string} key @returns {CardName} */
  neighbour(name, key) {
    return this.#stepOf(this.#neighbour(name, key));
  }

  /** Returns the layer of a card; other cards have their own name. @param {CardName} name */
  #laneOf(name) {
    const step = this.#stepOf(name);
    return typeof step === "number" && this.state ? placeOf(this.state, step)?.layer : step;
  }

  /** @param {CardName} name @param {string} key @returns {CardName} */
  #neighbour(name, key) {
    const cards = this.layout?.stops ?? [];
    const at = cards.findIndex((card) => card.name === name);
    if (at < 0) return "source";
    // Along the wires: lines begin after the base, as the background does, and the background ends at the result.
    const lane = this.#laneOf(name);
    if (key === "ArrowLeft") return cards.slice(0, at).findLast((card) => lane !== "lines" || this.#laneOf(card.name) !== "background")?.name ?? name;
    if (key === "ArrowRight") return cards.slice(at + 1).find((card) => lane !== "background" || this.#laneOf(card.name) !== "lines")?.name ?? name;
    const down = key === "ArrowDown" ? 1 : -1;
    const others = cards.filter((card) => (card.row - cards[at].row) * down > 0);
    /** @param {typeof others[number]} card */
    const distance = (card) => Math.abs(card.row - cards[at].row) * 10000 + Math.abs(card.x - cards[at].x);
    return others.sort((one, other) => distance(one) - distance(other))[0]?.name ?? name;
  }

  /** Shows the thumbnail of a step. @param {number} step @param {Blob} file */
  picture(step, file) {
    const card = this.#cards.get(step);
    if (!card) return;
    const before = this.#pictures.get(step);
    const address = URL.createObjectURL(file);
    this.#pictures.set(step, address);
    const picture = /** @type {HTMLImageElement} */ (card.firstElementChild);
    picture.src = address;
    const fold = /** @type {HTMLImageElement | null} */ (this.area.querySelector(`.fold[data-last="${step}"] img`));
    if (fold) fold.src = address;
    if (before) picture.decode().catch(() => {}).then(() => URL.revokeObjectURL(before));
  }

  /** Frees the thumbnail of a step that was removed. @param {CardName} name */
  #discardPicture(name) {
    if (typeof name !== "number") return;
    URL.revokeObjectURL(this.#pictures.get(name) ?? "");
    this.#pictures.delete(name);
  }

  /** Removes the picture of the result, which shows another style. */
  clearResult() {
    const canvas = /** @type {HTMLCanvasElement | undefined} */ (this.#cards.get("result")?.firstElementChild);
    canvas?.getContext("2d")?.clearRect(0, 0, canvas.width, canvas.height);
  }

  /** Draws the picture of the source or the result. @param {"source" | "result"} name @param {CanvasImageSource} picture @param {[number, number]} size */
  draw(name, picture, [width, height]) {
    const canvas = /** @type {HTMLCanvasElement | undefined} */ (this.#cards.get(name)?.firstElementChild);
    const context = canvas?.getContext("2d");
    if (!canvas || !context) return;
    const scale = Math.max(canvas.width / width, canvas.height / height);
    const [w, h] = [canvas.width / scale, canvas.height / scale];
    context.drawImage(picture, (width - w) / 2, (height - h) / 2, w, h, 0, 0, canvas.width, canvas.height);
  }
}
