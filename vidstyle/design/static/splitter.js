/**
 * The bar between picture and diagram.
 *
 * @module
 */

import { get } from "./elements.js";

const LEAST = 120;
const STEP = 24;

/** Makes the diagram higher or lower. @param {() => void} onchange */
export function splitter(onchange) {
  const bar = get("splitter");
  const diagram = get("diagram");

  /** @param {number | null} height in CSS pixels; null: as the page starts */
  function set(height) {
    const most = Math.max(LEAST, get("work").clientHeight - 2 * LEAST);
    const text = height === null ? "" : `${Math.min(most, Math.max(LEAST, height))}px`;
    document.documentElement.style.setProperty("--diagram", text);
    bar.setAttribute("aria-valuenow", String(Math.round(diagram.clientHeight)));
    onchange();
  }

  bar.addEventListener("pointerdown", (event) => bar.setPointerCapture(event.pointerId));
  bar.addEventListener("pointermove", (event) => {
    if (bar.hasPointerCapture(event.pointerId)) set(diagram.getBoundingClientRect().bottom - event.clientY);
  });
  bar.addEventListener("dblclick", () => set(null));
  bar.addEventListener("keydown", (event) => {
    const steps = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    if (steps) set(diagram.clientHeight + steps * STEP);
  });
}
