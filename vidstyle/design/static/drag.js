// Dragging of cards within and between the layers of a diagram.

import { make } from "./elements.js";
import { placeOf } from "./types.js";

/** Distance that a mouse moves before a drag starts, in CSS pixels. */
const START_PX = 6;
/** Time that a finger rests before a drag starts. */
const LONG_PRESS_MS = 350;
/** Largest distance from a gap at which a card drops into it, in CSS pixels. */
const MAX_DROP_PX = 140;

/** Makes the cards of a diagram draggable. @param {import("./diagram.js").Diagram} diagram */
export function enableDragging(diagram) {
  const { area, root } = diagram;
  /** @type {{card: HTMLElement, step: number, x: number, y: number, id: number} | null} */
  let held = null;
  /** @type {HTMLElement | null} */
  let ghost = null;
  /** @type {HTMLElement | null} */
  let target = null;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let rest;

  function start() {
    if (!held) return;
    ghost = make("div", { className: "ghost" });
    ghost.append(.../** @type {HTMLElement} */ (held.card.cloneNode(true)).childNodes);
    Object.assign(ghost.style, { width: held.card.style.width, height: held.card.style.height });
    document.body.append(ghost);
    held.card.classList.add("dragged");
    root.classList.add("dragging");
    held.card.setPointerCapture(held.id);
  }

  /** @param {number} x @param {number} y */
  function nearest(x, y) {
    /** @param {Element} gap */
    const distance = (gap) => {
      const { left, top, width, height } = gap.getBoundingClientRect();
      return Math.hypot(left + width / 2 - x, (top + height / 2 - y) * 1.5);
    };
    const gaps = /** @type {HTMLElement[]} */ ([...area.querySelectorAll(".gap")]);
    const best = gaps.map((gap) => ({ gap, far: distance(gap) })).sort((one, other) => one.far - other.far)[0];
    return best && best.far < MAX_DROP_PX ? best.gap : null;
  }

  function end() {
    clearTimeout(rest);
    ghost?.remove();
    held?.card.classList.remove("dragged");
    root.classList.remove("dragging");
    target?.classList.remove("target");
    held = ghost = target = null;
  }

  area.addEventListener("pointerdown", (event) => {
    const card = /** @type {HTMLElement | null} */ (/** @type {Element} */ (event.target).closest(".card"));
    const step = Number(card?.dataset.card);
    if (!card || event.button || Number.isNaN(step)) return;
    held = { card, step, x: event.clientX, y: event.clientY, id: event.pointerId };
    if (event.pointerType === "touch") rest = setTimeout(start, LONG_PRESS_MS);
  });

  addEventListener("pointermove", (event) => {
    if (!held || event.pointerId !== held.id) return;
    const far = Math.hypot(event.clientX - held.x, event.clientY - held.y) > START_PX;
    if (!ghost && far && event.pointerType === "touch") end();
    else if (!ghost && far) start();
    if (!ghost) return;
    ghost.style.translate = `${event.clientX + 16}px ${event.clientY + 16}px`; // the target stays in view
    target?.classList.remove("target");
    target = nearest(event.clientX, event.clientY);
    target?.classList.add("target");
  });

  addEventListener("pointerup", (event) => {
    if (!held || event.pointerId !== held.id) return;
    const { step, card } = held;
    const gap = ghost && target?.dataset;
    if (ghost) card.addEventListener("click", (click) => click.stopImmediatePropagation(), { once: true, capture: true });
    end();
    if (gap) drop(step, /** @type {import("./types.js").Layer} */ (gap.layer), Number(gap.index));
  });
  addEventListener("pointercancel", end);
  addEventListener("keydown", (event) => {
    if (event.key === "Escape" && ghost) end();
  }, true);
  area.addEventListener("touchmove", (event) => ghost && event.preventDefault(), { passive: false });

  /** @param {number} step @param {import("./types.js").Layer} layer @param {number} index of the gap */
  function drop(step, layer, index) {
    const state = diagram.state;
    const place = state && placeOf(state, step);
    if (!place) return;
    const after = place.layer === layer && place.index < index ? index - 1 : index;
    if (place.layer !== layer || place.index !== after) diagram.actions.move(step, layer, after);
  }
}
