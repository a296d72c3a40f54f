// The button that shows the original in place of the result.

/** A shorter press is a click. */
const MAX_CLICK_MS = 350;

/**
 * Shows the original after a click until the next, or while the button is held.
 * @param {HTMLElement} button
 * @param {() => boolean} isShown returns whether the original is shown
 * @param {(on: boolean) => void} show
 */
export function switchOriginal(button, isShown, show) {
  let [since, wasShown, isHeld] = [0, false, false];
  button.addEventListener("pointerdown", (event) => {
    button.setPointerCapture(event.pointerId);
    [since, wasShown, isHeld] = [event.timeStamp, isShown(), true];
    show(true);
  });
  for (const kind of ["pointerup", "pointercancel"])
    button.addEventListener(kind, (event) => {
      if (isHeld) show(!wasShown && event.timeStamp - since < MAX_CLICK_MS);
      isHeld = false;
    });
  button.addEventListener("click", ({ detail }) => !detail && show(!isShown())); // by keyboard
}
