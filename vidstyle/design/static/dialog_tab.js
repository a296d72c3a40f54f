// The Tab key inside dialogs: browsers let it leave a modal dialog for the bars of their window.

/** What the Tab key stops at. */
const STOPS = "a[href], button, input, select, summary, textarea, video[controls], [tabindex]";

/** Returns the stops of the Tab key in a dialog, in their order. @param {Element} dialog */
function stopsIn(dialog) {
  const stops = /** @type {HTMLInputElement[]} */ ([...dialog.querySelectorAll(STOPS)]);
  return stops.filter((stop) => stop.tabIndex >= 0 && !stop.disabled && stop.checkVisibility() && (stop.type !== "radio" || stop.checked));
}

/** Lets the Tab key go from the last stop of an open dialog to its first, and back. */
export function keepTabInDialogs() {
  addEventListener("keydown", (event) => {
    const open = [...document.querySelectorAll("dialog:modal")];
    const dialog = open.find((each) => each.contains(document.activeElement)) ?? open.at(-1);
    if (event.key !== "Tab" || !dialog) return;
    const stops = stopsIn(dialog), at = stops.indexOf(/** @type {HTMLInputElement} */ (document.activeElement));
    const last = event.shiftKey ? 0 : stops.length - 1;
    if (at >= 0 && at !== last) return;
    event.preventDefault();
    stops.at(event.shiftKey ? -1 : 0)?.focus();
  });
}
