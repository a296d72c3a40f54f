// Keyboard shortcuts: one table defines the key bindings and the help dialog.

import { get, make } from "./elements.js";

/**
 * @typedef {object} Shortcut
 * @property {string[]} keys `KeyboardEvent.key`, prefixed with "Ctrl+", "Alt+" and "Shift+"
 * @property {string} help
 * @property {string} [group] heading of this shortcut and those after it
 * @property {(event: KeyboardEvent) => unknown} run
 * @property {() => unknown} [end] is called when the key is released
 * @property {boolean} [inControl] whether the focused control handles it itself, so that it is only listed
 * @property {boolean} [typing] whether its keys that are no letters also work in text fields
 */

/** @type {Object<string, string>} */
const KEY_NAMES = { " ": "Space", ArrowLeft: "←", ArrowRight: "→", ArrowUp: "↑", ArrowDown: "↓", Escape: "Esc", Delete: "Del" };

/** Returns the key of an event with its modifiers, as in the table. @param {KeyboardEvent} event */
function nameOf(event) {
  const control = event.ctrlKey || event.metaKey ? "Ctrl+" : "";
  const digit = event.shiftKey && /^Digit\d$/.test(event.code) ? event.code.slice(5) : "";
  const key = digit || (event.key.length === 1 ? event.key.toLowerCase() : event.key);
  const letter = key.length > 1 || /[a-z]/.test(key) || digit;
  return control + (event.altKey ? "Alt+" : "") + (event.shiftKey && letter ? "Shift+" : "") + key;
}

/** Whether the focused control handles the key itself. @param {KeyboardEvent} event */
function isHandledByControl(event) {
  const target = /** @type {Element} */ (event.target);
  if (target.matches("input:not([type=range], [type=checkbox], [type=color], [type=radio]), textarea")) return true;
  const moves = event.key.startsWith("Arrow") || event.key.startsWith("Page") || ["Home", "End"].includes(event.key);
  if (target.matches("select")) return moves || event.key.length === 1;
  if (target.matches("input, [role=separator], [role=slider]")) return moves || event.key === " ";
  return target.matches("button:not(.card), summary, a") && [" ", "Enter"].includes(event.key);
}

/** Installs the key bindings. @param {Shortcut[]} shortcuts */
export function listen(shortcuts) {
  const byKey = new Map(shortcuts.filter(({ inControl }) => !inControl).flatMap((shortcut) => shortcut.keys.map((key) => [key, shortcut])));
  /** @type {Map<string, Shortcut>} */
  const held = new Map();
  addEventListener("keydown", (event) => {
    const shortcut = /** @type {Shortcut | undefined} */ (byKey.get(nameOf(event)));
    if (!shortcut || event.isComposing || document.querySelector("dialog[open]")) return;
    const isWhileTyping = shortcut.typing && nameOf(event).length > 1;
    if (!isWhileTyping && isHandledByControl(event)) return;
    if (event.repeat && shortcut.end) return event.preventDefault();
    if (shortcut.run(event) === false) return;
    event.preventDefault();
    if (shortcut.end) held.set(event.code, shortcut);
  });
  addEventListener("keyup", (event) => {
    held.get(event.code)?.end?.();
    held.delete(event.code);
  });
  addEventListener("blur", () => {
    for (const shortcut of held.values()) shortcut.end?.();
    held.clear();
  });
}

/** Fills the help dialog. @param {Shortcut[]} shortcuts */
export function describe(shortcuts) {
  /** @type {HTMLElement[]} */
  const groups = [];
  for (const { keys, help, group } of shortcuts) {
    if (group) groups.push(make("section", {}, make("h3", { textContent: group }), make("dl")));
    const shown = keys.slice(0, 4).map((key) => key.split(/\+(?=.)/).map((part) => KEY_NAMES[part] ?? part.replace(/^[a-z]$/, (letter) => letter.toUpperCase())));
    const marks = shown.map((parts) => make("kbd", { textContent: parts.join(" ") }));
    groups.at(-1)?.lastElementChild?.append(make("dt", {}, ...marks), make("dd", { textContent: help }));
  }
  get("shortcuts").replaceChildren(...groups);
}
