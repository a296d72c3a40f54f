// The button of a variant, with a swatch of its ink and paper.

import { make, title } from "./elements.js";

/** @typedef {{name: string, ink?: string, paper?: string}} Variant */

/** Returns a button. @param {Variant} variant @param {() => void} onclick */
export function variantChip({ name, ink, paper }, onclick) {
  const button = make("button", { type: "button", onclick }, title(name.replaceAll("-", " ")));
  button.dataset.name = name;
  if (ink && paper) {
    const swatch = make("span", { className: "swatch" });
    swatch.style.background = `linear-gradient(${paper} 50%, ${ink} 50%)`;
    button.prepend(swatch);
  }
  return button;
}
