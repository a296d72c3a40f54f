// Reading a comic in the browser: theme, size of the pages, full screen, keys.

import { get, icon, press } from "./elements.js";
import { SHARED_KEYS } from "./shared_keys.js";
import { switchTheme } from "./theme.js";

/** A page that is longer, for its width, is a strip: it never fits into a window. */
const MAX_PAGE_ASPECT = 2.5;

const pages = /** @type {SVGSVGElement[]} */ ([...document.querySelectorAll("main > svg")]);
const help = /** @type {HTMLDialogElement} */ (get("help"));

/** The number of the page at the top of the window. */
function current() {
  const top = pages.findIndex((page) => page.getBoundingClientRect().bottom > innerHeight / 2);
  return top < 0 ? pages.length - 1 : top;
}

/** Scrolls to the next page or the one before. @param {number} by */
const turn = (by) => pages[Math.min(Math.max(current() + by, 0), pages.length - 1)]?.scrollIntoView();

/** Fits pages into the window, or their width; the page in view stays. */
function zoom() {
  const page = current();
  press(get("zoom"), document.body.classList.toggle("whole"));
  pages[page].scrollIntoView();
}

function fill() {
  if (document.fullscreenElement) document.exitFullscreen();
  else document.documentElement.requestFullscreen?.().catch(() => {});
}

/** @type {Object<string, () => void>} */
const KEYS = {
  [SHARED_KEYS.next]: () => turn(1),
  ArrowRight: () => turn(1),
  ArrowLeft: () => turn(-1),
  [SHARED_KEYS.zoom]: () => get("zoom").click(),
  [SHARED_KEYS.full]: fill,
  [SHARED_KEYS.help]: () => help.showModal(),
};

for (const [id, name] of /** @type {const} */ ([["full", "fit"], ["theme", "theme"], ["ask", "help"]])) get(id).prepend(icon(name));
const isStrip = pages.some(({ viewBox: { baseVal: { width, height } } }) => height > MAX_PAGE_ASPECT * width);
document.body.classList.toggle("strip", isStrip);
get("zoom").hidden = isStrip;
if (!isStrip && innerWidth > innerHeight) zoom(); // a whole page is seen first
get("zoom").addEventListener("click", zoom);
get("full").addEventListener("click", fill);
get("full").hidden = !document.fullscreenEnabled;
get("ask").addEventListener("click", () => help.showModal());
switchTheme(get("theme"));
addEventListener("keydown", (event) => {
  const isText = /** @type {HTMLElement} */ (event.target).matches("textarea, input");
  if (isText || event.altKey || event.ctrlKey || event.metaKey || help.open) return;
  const key = event.key.length > 1 ? event.key : event.key.toLowerCase();
  const run = KEYS[key];
  if (!run || (key.startsWith("Arrow") && document.activeElement?.matches(".editable"))) return;
  event.preventDefault();
  run();
});
