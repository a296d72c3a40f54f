// Renaming of a knob: a button next to its label, and a text field in place of the label.

import { icon, make } from "./elements.js";

/** @typedef {import("./types.js").Entry} Entry */

/** Maximum length of a label, in characters. */
const MAX_LENGTH = 40;

/**
 * Returns the button that replaces a label by a text field, until Enter, Escape or a click elsewhere.
 * @param {Entry} entry
 * @param {HTMLElement} label
 * @param {(text: string) => unknown} rename is called with a new label; "" restores the one of the parameter
 */
export function renameButton(entry, label, rename) {
  const button = make("button", { className: "pin", type: "button", title: "Rename in this style" }, icon("rename"));
  button.setAttribute("aria-label", `Rename ${entry.label}`);
  button.addEventListener("click", () => {
    const field = make("input", { type: "text", className: "rename", value: entry.label, maxLength: MAX_LENGTH });
    field.setAttribute("aria-label", `New name of ${entry.label}`);
    let isOpen = true;
    const end = (/** @type {boolean} */ keep) => {
      if (!isOpen) return; // its removal blurs it, too
      isOpen = false;
      const text = field.value.trim();
      field.replaceWith(label);
      if (keep && text !== entry.label) rename(text);
    };
    field.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== "Escape") return;
      event.stopPropagation();
      end(event.key === "Enter");
      document.getElementById(label.getAttribute("for") ?? "")?.focus();
    });
    field.addEventListener("blur", () => end(true));
    label.replaceWith(field);
    field.select();
  });
  return button;
}
