// The page of a preview sheet. `vidstyle.gallery.preview` joins it with the modules that it imports.

import { get, press, title } from "./elements.js";
import { SHARED_KEYS } from "./shared_keys.js";
import { switchTheme } from "./theme.js";

const figures = /** @type {HTMLElement[]} */ ([...document.querySelectorAll("main figure")]);
const [large, help] = ["large", "help"].map((id) => /** @type {HTMLDialogElement} */ (get(id)));
const [before, after] = ["before", "after"].map((id) => /** @type {HTMLImageElement} */ (get(id)));
/** The number of the enlarged style; the first is the original. */
let shown = 0;
let isSplit = true;

/** @param {number} number */
const pictureOf = (number) => /** @type {HTMLImageElement} */ (figures[number].querySelector("img"));

/** Enlarges a style. @param {number} number */
function show(number) {
  shown = (number + figures.length) % figures.length;
  const { alt, src } = pictureOf(shown);
  before.src = pictureOf(0).src;
  Object.assign(after, { src, alt });
  for (const id of ["name", "tag"]) get(id).textContent = title(alt);
  get("count").textContent = shown ? `${shown} of ${figures.length - 1}` : "";
  const note = figures[shown].querySelector(".note")?.cloneNode(true);
  get("note").replaceChildren(...(note?.childNodes ?? []));
  get("command").textContent = String(figures[shown].dataset.command);
  split(isSplit);
  if (!large.open) large.showModal();
}

/** Shows the original next to the style, or only the style. @param {boolean} on */
function split(on) {
  isSplit = on;
  press(get("split"), on);
  large.classList.toggle("alone", !on || !shown);
}

/** Shows only the original while a key or a button is held. @param {boolean} on */
function hold(on) {
  large.classList.toggle("held", on);
  large.classList.toggle("alone", on || !isSplit || !shown);
}

async function copy() {
  try {
    await navigator.clipboard.writeText(String(get("command").textContent));
    get("copy").textContent = "Copied";
  } catch {
    getSelection()?.selectAllChildren(get("command"));
    get("copy").textContent = "Selected";
  }
  setTimeout(() => (get("copy").textContent = "Copy"), 1500);
}

const focused = () => figures.findIndex((figure) => figure.contains(document.activeElement));

/** @type {Object<string, () => void>} */
const KEYS = {
  ArrowLeft: () => show(shown - 1),
  ArrowRight: () => show(shown + 1),
  [SHARED_KEYS.next]: () => show(shown + 1),
  [SHARED_KEYS.compare]: () => split(!isSplit),
  [SHARED_KEYS.original]: () => hold(true),
  [SHARED_KEYS.zoom]: () => large.close(),
};

for (const [number, figure] of figures.entries()) {
  figure.querySelector("button")?.addEventListener("click", () => show(number));
  figure.querySelector("strong")?.replaceChildren(title(pictureOf(number).alt));
}
get("previous").addEventListener("click", () => show(shown - 1));
get("next").addEventListener("click", () => show(shown + 1));
get("split").addEventListener("click", () => split(!isSplit));
get("hold").addEventListener("pointerdown", () => hold(true));
get("close").addEventListener("click", () => large.close());
get("copy").addEventListener("click", copy);
get("ask").addEventListener("click", () => help.showModal());
for (const kind of ["pointerup", "pointercancel", "blur"]) addEventListener(kind, () => hold(false));
addEventListener("keyup", (event) => event.key.toLowerCase() === SHARED_KEYS.original && hold(false));
addEventListener("keydown", (event) => {
  if (event.altKey || event.ctrlKey || event.metaKey || help.open) return;
  const key = event.key.length > 1 ? event.key : event.key.toLowerCase();
  if (key === SHARED_KEYS.help) help.showModal();
  else if (large.open && KEYS[key]) KEYS[key]();
  else if (!large.open && key === SHARED_KEYS.zoom) show(Math.max(0, focused()));
  else return;
  event.preventDefault();
});
large.addEventListener("close", () => figures[shown].querySelector("button")?.focus());
switchTheme(get("theme"));
