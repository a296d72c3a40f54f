// Messages to the user.

/** @type {WeakMap<HTMLElement, ReturnType<typeof setTimeout>>} */
const timers = new WeakMap();

/**
 * Shows a message for some seconds (class "shown") and announces it to screen readers.
 * @param {HTMLElement} line an element with the role "status"
 * @param {string} text
 * @param {object} [options]
 * @param {boolean} [options.alarm] whether it reports an error (class "alarm")
 * @param {boolean} [options.visible] whether it is shown as well as announced
 * @param {number} [options.seconds] 0: until the next message
 */
export function announce(line, text, { alarm = false, visible = true, seconds = alarm ? 9 : 5 } = {}) {
  line.textContent = text;
  line.classList.toggle("alarm", alarm);
  line.classList.toggle("shown", visible && Boolean(text));
  clearTimeout(timers.get(line));
  if (seconds) timers.set(line, setTimeout(() => line.classList.remove("shown"), 1000 * seconds));
}
