// The button of a variant, with a swatch of its ink and paper.

import { make, title } from "./elements.js";

/** `name`: "" for the style without a variant. @typedef {{name: string, ink?: string, paper?: string, colors?: string[]}} Variant */

/** Returns bands of colours, one next to the other. @param {string[]} colors */
const bandsOf = (colors) => colors.map((color, at) => `${color} ${(100 * at) / colors.length}% ${(100 * (at + 1)) / colors.length}%`).join(", ");

/** Returns variants with the colours of their swatches, if these tell them apart. @template {Variant} Kind @param {Kind[]} variants @returns {Kind[]} */
export function withSwatches(variants) {
  const colors = new Set(variants.map(({ ink, paper, colors = [] }) => [ink, paper, ...colors].join()));
  return colors.size > 1 ? variants : variants.map((variant) => ({ ...variant, ink: "", colors: [] }));
}

/** Returns a button. @param {Variant} variant @param {() => void} onclick */
export function variantChip({ name, ink, paper, colors = [] }, onclick) {
  const button = make("button", { type: "button", onclick }, title((name || "standard").replaceAll("-", " ")));
  button.dataset.name = name;
  const shown = colors.length > 1 ? colors : paper && ink ? [paper, ink] : [];
  if (shown.length) {
    const swatch = make("span", { className: "swatch" });
    swatch.style.background = `linear-gradient(${bandsOf(shown)})`;
    button.prepend(swatch);
  }
  return button;
}
