// Editing a comic: balloons are dragged and words changed, and the page or its page file is saved with these changes.

import { draw, readBubble } from "./bubble_shapes.js";
import { allWords, editedFile, editedPage, inCapitals } from "./edited_page.js";
import { download, get, icon, make, press } from "./elements.js";
import { fitWords, moveInto, roomOf } from "./fitted_words.js";

/** @typedef {import("./bubble_shapes.js").Bubble} Bubble */

/** A pointer that has moved so far drags. */
const MIN_DRAG_PX = 3;
/** The smallest font and width of the field for words on the screen: it is not larger than its balloon, unless that is tiny. */
const [MIN_FONT_PX, MIN_FIELD_PX] = [13, 90];
/** @type {Record<string, number[]>} */
const STEPS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const [SHORT_STEP, LONG_STEP] = [4, 20];
const HINT = `${matchMedia("(pointer: coarse)").matches ? "Tap" : "Click"} words to change them; drag a balloon to move it.`;
const TYPING = "Enter accepts the words, Shift + Enter starts a new line, Esc cancels.";
const UNSAVED = "Changed, not saved yet. “Done” keeps the change until this page is closed.";

const groups = /** @type {SVGGElement[]} */ ([...document.querySelectorAll("main g[data-place]")]);
const bubbles = allWords.length ? groups.map((group, number) => readBubble(group, number, allWords[number], inCapitals)) : [];
/** Earlier places and words, for undo. @type {[Bubble, {place: number[], words: string, size: number}][]} */
const past = [];
/** The last change that is saved. @type {(typeof past)[0] | undefined} */
let saved;
/** Whether the last press on a balloon has dragged it. */
let isDragged = false;

const isEditing = () => document.body.matches(".editing");
/** Whether a bubble has a shape that can be moved. @param {Bubble} bubble */
const isMovable = ({ group }) => !group.matches(".band");

/** Changes the words or the place of a bubble, with undo. @param {Bubble} bubble @param {{place?: number[], words?: string, size?: number}} next */
function change(bubble, next) {
  past.push([bubble, { place: bubble.place, words: bubble.words, size: bubble.size }]);
  Object.assign(bubble, next);
  show(bubble);
}

function takeBack() {
  const last = past.pop();
  if (!last) return;
  Object.assign(...last);
  show(last[0]);
}

/** Returns a hint for editing, or that an edit is not saved. */
const adviceNow = () => (past.at(-1) === saved ? HINT : UNSAVED);

/** @param {Bubble} bubble */
function show(bubble) {
  draw(bubble);
  undo.disabled = !past.length;
  hint.textContent = adviceNow();
  mark(bubble);
}

/** Makes a bubble a button while the comic is edited. @param {Bubble} bubble */
function mark({ group, words }) {
  const text = words.replaceAll("\n", " ");
  const label = `${text}${/[.!?…]$/.test(text) ? "" : "."} Enter changes the words, arrows move them.`;
  for (const [name, value] of Object.entries({ tabindex: "0", role: "button", "aria-label": label }))
    if (isEditing()) group.setAttribute(name, value);
    else group.removeAttribute(name);
  group.classList.toggle("editable", isEditing());
}

/** Opens a field for the words of a bubble. @param {Bubble} bubble */
function edit(bubble) {
  const { group, words, size, place } = bubble;
  const { a, d, e, f } = /** @type {DOMMatrix} */ (group.getScreenCTM());
  const box = { left: a * place[0] + e, top: d * place[1] + f, width: a * (place[2] - place[0]), height: d * (place[3] - place[1]) };
  const input = make("textarea", { className: "words", value: words, ariaLabel: "Words" });
  const width = Math.min(Math.max(box.width, MIN_FIELD_PX), innerWidth - 16);
  const left = Math.min(Math.max(8, box.left + box.width / 2 - width / 2), innerWidth - width - 8);
  const font = Math.max(size * a, MIN_FONT_PX);
  Object.assign(input.style, { left: `${left + scrollX}px`, width: `${width}px`, font: `${font}px/1.2 ${getComputedStyle(group).fontFamily}` });
  if (bubble.inCapitals) input.style.textTransform = "uppercase";
  const grow = () => {
    input.style.height = "0";
    const height = Math.max(box.height, input.scrollHeight + 6);
    Object.assign(input.style, { height: `${height}px`, top: `${box.top + scrollY + (box.height - height) / 2}px` });
  };
  document.body.append(input);
  grow();
  input.focus();
  input.select();
  hint.textContent = TYPING;
  input.addEventListener("input", grow);
  let isCancelled = false;
  input.addEventListener("keydown", (event) => {
    event.stopPropagation();
    if (event.key === "Escape") [input.value, isCancelled] = [words, input.value !== words];
    if (event.key === "Escape" || (event.key === "Enter" && !event.shiftKey)) input.blur();
  });
  input.addEventListener("blur", () => {
    const typed = input.value.split("\n").map((line) => line.trim().replace(/\s+/g, " ")).filter(Boolean).join("\n");
    input.remove();
    hint.textContent = isCancelled ? "Cancelled: the words are as before." : adviceNow();
    if (typed && typed !== words) change(bubble, placeWords(bubble, typed));
    group.focus();
  });
}

/** Returns new words in lines, with their size and their place in the panel. @param {Bubble} bubble @param {string} typed */
const placeWords = (bubble, typed) =>
  isMovable(bubble) ? fitWords(bubble, typed, roomOf(bubble)) : { ...fitWords(bubble, typed), place: bubble.place };

/** Returns a place moved by a distance, at most to the edge of its page. @param {Bubble} bubble @param {number[]} by */
function moved({ group, place }, by) {
  const page = /** @type {SVGSVGElement} */ (group.ownerSVGElement).viewBox.baseVal;
  return moveInto(place.map((side, at) => side + by[at % 2]), page);
}

/** @param {Bubble} bubble @param {PointerEvent} event */
function drag(bubble, event) {
  isDragged = false;
  if (event.button !== 0 || !isEditing() || !isMovable(bubble)) return;
  const { group, place: from } = bubble;
  const scale = group.getScreenCTM()?.a ?? 1;
  group.setPointerCapture(event.pointerId);
  const move = (/** @type {PointerEvent} */ to) => {
    const by = [to.clientX - event.clientX, to.clientY - event.clientY];
    isDragged ||= Math.hypot(...by) > MIN_DRAG_PX;
    if (!isDragged) return;
    group.classList.add("held");
    bubble.place = moved({ ...bubble, place: from }, by.map((distance) => distance / scale));
    draw(bubble);
  };
  const drop = () => {
    group.removeEventListener("pointermove", move);
    group.classList.remove("held");
    const { place } = bubble;
    bubble.place = from;
    if (isDragged) change(bubble, { place });
  };
  group.addEventListener("pointermove", move);
  group.addEventListener("lostpointercapture", drop, { once: true });
}

/** @param {Bubble} bubble @param {KeyboardEvent} event */
function pressKey(bubble, event) {
  if (event.target !== bubble.group || !isEditing()) return;
  const step = STEPS[event.key];
  const length = event.shiftKey ? LONG_STEP : SHORT_STEP;
  if (step && isMovable(bubble)) change(bubble, { place: moved(bubble, step.map((each) => length * each)) });
  else if (event.key === "Enter") edit(bubble);
  else return;
  event.preventDefault();
}

/** Downloads the comic with its changes, and says what the file is for. @param {string} text @param {string} type @param {string} name @param {string} use */
function save(text, type, name, use) {
  download(new Blob([text], { type }), name);
  saved = past.at(-1);
  hint.textContent = `${name} is in your downloads. ${use}`;
}

const savePage = () => save(editedPage(bubbles), "text/html", decodeURIComponent(location.pathname.split("/").pop() || "comic.html"), "It shows the comic with your changes.");
const saveFile = () => save(editedFile(bubbles), "application/toml", "comic.toml", "Put it next to this page; “vidstyle comic comic.toml pages.pdf” draws the pages.");

/** @param {boolean} on @param {boolean} [isByKeyboard] whether to move the focus to the first balloon in view */
function switchEditing(on, isByKeyboard = false) {
  document.body.classList.toggle("editing", on);
  press(get("edit"), on);
  bar.hidden = !on;
  hint.textContent = adviceNow();
  get("edit-label").textContent = on || past.at(-1) === saved ? "Edit" : "Edit, not saved";
  bubbles.forEach(mark);
  for (const panel of /** @type {NodeListOf<SVGGElement>} */ (document.querySelectorAll(".panel"))) panel.tabIndex = on ? -1 : 0;
  if (!on) get("edit").focus();
  else if (isByKeyboard) groups.find((group) => group.getBoundingClientRect().bottom > 0)?.focus();
}

const hint = make("p", { role: "status" });
const undo = make("button", { type: "button", textContent: "Undo", disabled: true, onclick: takeBack });
const bar = make("div", { className: "bar", hidden: true }, hint, undo,
  make("button", { type: "button", textContent: "Save page", className: "strong", title: "Save this page with your changes", onclick: savePage }),
  make("button", { type: "button", textContent: "Save for vidstyle", title: "Save the words and places as comic.toml, from which vidstyle draws the pages again, also as PDF", onclick: saveFile }),
  make("button", { type: "button", textContent: "Done", title: "Stop editing: changes stay until the page is closed, save it to keep them (Esc)", onclick: () => switchEditing(false) }));

if (bubbles.length) {
  for (const bubble of bubbles) {
    const { group } = bubble;
    group.addEventListener("pointerdown", (event) => drag(bubble, event));
    group.addEventListener("click", () => isEditing() && !isDragged && edit(bubble));
    group.addEventListener("keydown", (event) => pressKey(bubble, event));
  }
  for (const each of document.querySelectorAll("[data-edit]")) each.removeAttribute("hidden");
  document.body.append(bar);
  get("edit").prepend(icon("rename"));
  get("edit").addEventListener("click", ({ detail }) => switchEditing(!isEditing(), !detail));
  addEventListener("keydown", (event) => {
    if (document.querySelector("dialog[open]") || event.altKey || event.ctrlKey || event.metaKey) return;
    if (event.key.toLowerCase() === "e") switchEditing(!isEditing(), true);
    else if (event.key === "Escape" && isEditing()) switchEditing(false);
  });
  addEventListener("beforeunload", (event) => past.at(-1) !== saved && event.preventDefault());
} else get("no-words").hidden = false;
