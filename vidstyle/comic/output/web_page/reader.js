// Reading a comic in the browser: theme, size of the pages, full screen, print, keys.

import { get, icon } from "./elements.js";
import { reducePictures } from "./fine_pictures.js";
import { NARROW, PanelView } from "./panel_view.js";
import { SHARED_KEYS } from "./shared_keys.js";
import { switchTheme } from "./theme.js";

/** A page that is longer, for its width, is a strip: it never fits into a window. */
const MAX_PAGE_ASPECT = 2.5;
/** The largest height of a panel there, its distance to the next one, and their common margin, relative to the width of the page. */
const [MAX_STACKED_HEIGHT_RATIO, STACK_GUTTER_RATIO, STACK_MARGIN_RATIO] = [1.3, 0.025, 0.015];
/** The title is as wide there as this part of the page, but not larger than by this factor. */
const [HEADING_RATIO, MAX_HEADING_GAIN] = [0.9, 2];

const pages = /** @type {SVGSVGElement[]} */ ([...document.querySelectorAll("main > svg")]);
const boxes = pages.map((page) => page.getAttribute("viewBox") ?? "");
const panels = /** @type {SVGGElement[]} */ ([...document.querySelectorAll("main > svg > g[id^=panel-]")]);
const help = /** @type {HTMLDialogElement} */ (get("help"));
/** The pages in the window or near it. @type {Set<Element>} */
const near = new Set();
const view = new PanelView(panels, () => near.forEach(refine));

/** The number of the page in the middle of the window. */
function current() {
  const top = pages.findIndex((page) => page.getBoundingClientRect().bottom > innerHeight / 2);
  return top < 0 ? pages.length - 1 : top;
}

/** Scrolls to the next page or the one before. @param {number} by */
const turn = (by) => pages[Math.min(Math.max(current() + by, 0), pages.length - 1)]?.scrollIntoView();

/** Shows the pictures of a page at their size on the screen; an enlarged panel keeps its own. @param {Element} page */
function refine(page) {
  if (view.isOpen) return;
  for (const panel of /** @type {NodeListOf<SVGGElement>} */ (page.querySelectorAll(":scope > g"))) {
    const { a } = /** @type {DOMMatrix} */ (panel.getScreenCTM());
    reducePictures(panel, a * devicePixelRatio);
  }
}

/** Gives panels with slanted edges upright ones, which show the corners of their pictures, or their own again. @param {Iterable<SVGGElement>} shown @param {boolean} on */
function straighten(shown, on) {
  for (const panel of shown) {
    for (const shape of /** @type {NodeListOf<SVGPolygonElement>} */ (panel.querySelectorAll("polygon.frame, clipPath polygon"))) {
      shape.dataset.slanted ??= shape.getAttribute("points") ?? "";
      const points = shape.dataset.slanted.split(" ").map((point) => point.split(",").map(Number));
      const [[left, right], [top, bottom]] = [0, 1].map((axis) => points.map((point) => point[axis])).map((all) => [Math.min(...all), Math.max(...all)]);
      shape.setAttribute("points", on ? `${left},${top} ${right},${top} ${right},${bottom} ${left},${bottom}` : shape.dataset.slanted);
    }
  }
}

/** Places the panels of a page one below the other, each as wide as the page, with equal borders. @param {SVGSVGElement} page */
function stack(page) {
  const { width } = page.viewBox.baseVal;
  const [margin, gutter] = [STACK_MARGIN_RATIO * width, STACK_GUTTER_RATIO * width];
  const shown = /** @type {SVGGElement[]} */ ([...page.querySelectorAll(":scope > g")]);
  straighten(shown, true);
  const boxes = shown.map((panel) => panel.getBBox());
  const scales = boxes.map((box) => Math.min((width - 2 * margin) / box.width, (MAX_STACKED_HEIGHT_RATIO * width) / box.height));
  let top = margin + stackHeading(page, width, gutter);
  for (const [number, panel] of shown.entries()) {
    const [box, scale] = [boxes[number], scales[number]];
    panel.setAttribute("transform", `translate(${(width - scale * box.width) / 2 - scale * box.x} ${top - scale * box.y}) scale(${scale})`);
    panel.style.setProperty("--covered", String(2 * Number(panel.dataset.border) * (1 - Math.min(...scales) / scale)));
    top += scale * box.height + gutter;
  }
  const height = top - gutter + margin;
  page.setAttribute("viewBox", `0 0 ${width} ${height}`);
  page.style.aspectRatio = `${width / height}`;
}

/** Marks the title of a page: text above its panels. @param {SVGSVGElement} page */
function findHeading(page) {
  const tops = /** @type {SVGGElement[]} */ ([...page.querySelectorAll(":scope > g")]).map((panel) => panel.getBBox().y);
  const texts = /** @type {SVGTextElement[]} */ ([...page.querySelectorAll(":scope > text")]);
  texts.find((text) => text.getBBox().y + text.getBBox().height <= Math.min(...tops))?.classList.add("heading");
}

/** Places the title above the panels; returns the height that it takes. @param {SVGSVGElement} page @param {number} width @param {number} gutter */
function stackHeading(page, width, gutter) {
  const heading = /** @type {SVGTextElement | null} */ (page.querySelector(":scope > .heading"));
  if (!heading) return 0;
  const box = heading.getBBox();
  const scale = Math.min(MAX_HEADING_GAIN, (HEADING_RATIO * width) / box.width);
  heading.setAttribute("transform", `translate(${width / 2 - scale * (box.x + box.width / 2)} ${gutter - scale * box.y}) scale(${scale})`);
  return scale * box.height + 2 * gutter;
}

/** Returns the panels and titles of all pages to their places. */
function unstack() {
  straighten(panels, false);
  for (const part of [...panels, ...document.querySelectorAll(".heading")]) part.removeAttribute("transform");
  for (const [number, page] of pages.entries()) {
    page.setAttribute("viewBox", boxes[number]);
    page.style.aspectRatio = "";
  }
}

/** What the button for the size of the pages says, and does next. */
const NEXT_SIZES = { width: ["Full width", "Pages as wide as the window (Z)"], whole: ["Whole page", "Fit whole pages into the window (Z)"] };

/** Shows whole pages, or pages as wide as the window; the page in view stays. @param {boolean} whole */
function arrange(whole) {
  const page = current();
  const [label, about] = whole ? NEXT_SIZES.width : NEXT_SIZES.whole;
  get("zoom").replaceChildren(icon(whole ? "result" : "fit"), NARROW.matches && whole ? "Panels" : label);
  get("zoom").title = about;
  document.body.classList.toggle("whole", whole);
  document.body.classList.toggle("stacked", NARROW.matches && !whole);
  unstack();
  if (NARROW.matches && !whole) pages.forEach(stack);
  view.refresh();
  if (page) pages[page].scrollIntoView();
  near.forEach(refine);
}

const zoom = () => arrange(!document.body.classList.contains("whole"));

function fill() {
  if (document.fullscreenElement) document.exitFullscreen();
  else document.documentElement.requestFullscreen?.().catch(() => {});
}

/** Moves the focus to the next panel or the one before, or to the first one in view. @param {number} by */
function step(by) {
  const at = panels.indexOf(/** @type {any} */ (document.activeElement));
  const seen = panels.findIndex((panel) => panel.getBoundingClientRect().bottom > innerHeight / 4);
  const panel = panels[at < 0 ? Math.max(seen, 0) : Math.min(Math.max(at + by, 0), panels.length - 1)];
  panel?.focus({ preventScroll: true });
  panel?.scrollIntoView({ block: "nearest" });
}

/** The size of a window is final once it has not changed for this time. */
const RESIZE_MS = 200;
/** @type {Object<string, () => void>} */
const KEYS = {
  ArrowRight: () => step(1),
  ArrowLeft: () => step(-1),
  [SHARED_KEYS.next]: () => turn(1),
  [SHARED_KEYS.zoom]: zoom,
  [SHARED_KEYS.full]: fill,
  [SHARED_KEYS.help]: () => help.showModal(),
};

for (const [id, name] of /** @type {const} */ ([["print", "print"], ["full", "expand"], ["theme", "theme"], ["ask", "help"], ["more", "more"]])) get(id).prepend(icon(name));
for (const page of pages) page.style.setProperty("--aspect", String(page.viewBox.baseVal.width / page.viewBox.baseVal.height));
pages.forEach(findHeading);
const isStrip = pages.some(({ viewBox: { baseVal: { width, height } } }) => height > MAX_PAGE_ASPECT * width);
document.body.classList.toggle("strip", isStrip);
get("zoom").hidden = isStrip;
// A single page is read as a whole.
get("read").classList.add(pages.length > 1 || isStrip ? "strong" : "plain");
// A whole page is seen first, except on a phone.
const begin = () => arrange(!isStrip && innerWidth > innerHeight);
begin();
const watcher = new IntersectionObserver((entries) => {
  for (const { target, isIntersecting } of entries) {
    if (isIntersecting) refine(target);
    near[isIntersecting ? "add" : "delete"](target);
  }
}, { rootMargin: "100% 0%" });
pages.forEach((page) => watcher.observe(page));
let resized = 0;
addEventListener("resize", () => {
  clearTimeout(resized);
  resized = setTimeout(() => near.forEach(refine), RESIZE_MS);
});
for (const shape of [NARROW, matchMedia("(orientation: portrait)")]) shape.addEventListener("change", begin);
get("zoom").addEventListener("click", zoom);
get("full").addEventListener("click", fill);
get("full").hidden = !document.fullscreenEnabled;
get("print").addEventListener("click", () => print());
addEventListener("beforeprint", unstack);
addEventListener("afterprint", () => arrange(document.body.classList.contains("whole")));
get("actions").addEventListener("click", () => get("actions").hidePopover?.());
get("ask").addEventListener("click", () => help.showModal());
switchTheme(get("theme"));
addEventListener("keydown", (event) => {
  const isText = /** @type {HTMLElement} */ (event.target).matches("textarea, input");
  if (isText || event.altKey || event.ctrlKey || event.metaKey || help.open || view.isOpen) return;
  const key = event.key.length > 1 ? event.key : event.key.toLowerCase();
  const run = KEYS[key];
  if (!run || (key.startsWith("Arrow") && document.activeElement?.matches(".editable"))) return;
  event.preventDefault();
  run();
});
