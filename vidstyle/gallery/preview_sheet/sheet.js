// The page of a preview sheet. `vidstyle.gallery.preview` joins it with the modules that it imports.

import { answer, withdraw } from "./button_answer.js";
import { columnsFor } from "./columns.js";
import { Comparison, listed, MAX_COMPARED } from "./comparison.js";
import { get, icon, make, press, saveAs, title } from "./elements.js";
import { describeSearch, findLooks, relatedLooks } from "./find_looks.js";
import { switchOriginal } from "./original_button.js";
import { rove } from "./roving.js";
import { summaryOf } from "./look_summary.js";
import { SHARED_KEYS } from "./shared_keys.js";
import { switchTheme } from "./theme.js";

const figures = /** @type {HTMLElement[]} */ ([...document.querySelectorAll("main figure")]);
const [large, help] = ["large", "help"].map((id) => /** @type {HTMLDialogElement} */ (get(id)));
const after = /** @type {HTMLImageElement} */ (get("after"));
const sheet = /** @type {HTMLElement} */ (document.querySelector("main"));
const finder = /** @type {HTMLInputElement} */ (get("find-look"));
/** The button for looks of all kinds. */
const ALL = "All";
let group = ALL;
let onlyStarred = false;
const relatedTitle = make("h2", { id: "related", textContent: "Related looks" });
/** The starred styles, the last one last. @type {HTMLElement[]} */
let starred = [];
/** The number of the enlarged style; the first is the original. */
let shown = 0;
/** Whether an enlarged style is shown next to the original. */
let isSplit = false;

/** The description of each style under its thumbnail. */
const abouts = figures.map((figure) => String(figure.querySelector(".about")?.textContent));

/** @param {number} number */
const pictureOf = (number) => /** @type {HTMLImageElement} */ (figures[number].querySelector("img"));

/** @param {number} number */
const nameOf = (number) => (number ? title(pictureOf(number).alt) : "Original");

/** Returns the note on a style. @param {number} number */
const noteOf = (number) => [...(figures[number].querySelector(".note")?.cloneNode(true).childNodes ?? [])];

/** Enlarges a style, or shows it next to the original. @param {number} number */
function show(number) {
  if (number !== shown) for (const id of ["save-word", "copy"]) withdraw(get(id));
  shown = number;
  const { alt, src } = pictureOf(shown);
  Object.assign(after, { src, alt });
  get("tag").textContent = get("name").textContent = nameOf(shown);
  const looks = seenFigures().filter((figure) => figure !== figures[0]);
  const place = looks.indexOf(figures[shown]);
  get("count").textContent = place < 0 ? "" : `${place + 1} of ${looks.length}`;
  get("note").replaceChildren(...noteOf(shown));
  describeUse();
  showStar();
  split(isSplit);
  if (!large.open) large.showModal();
}

/** Shows how the enlarged style is used. */
function describeUse() {
  const { alt } = pictureOf(shown);
  get("command").textContent = String(figures[shown].dataset.command);
  get("look").textContent = sheet.dataset.ending ? alt + sheet.dataset.ending : nameOf(shown);
}

/** Shows whether the enlarged style is starred. */
function showStar() {
  const star = starOf(figures[shown]);
  get("star").hidden = !star;
  press(get("star"), star?.ariaPressed === "true");
  get("star-word").textContent = star?.ariaPressed === "true" ? "Starred" : "Star";
}

/** @param {HTMLElement} figure @returns {HTMLElement | null} */
const starOf = (figure) => figure.querySelector(".star");

/** Shows the style next to the original, or alone. @param {boolean} on */
function split(on) {
  press(get("split"), on);
  large.classList.toggle("alone", !on || !shown);
}

/** Switches between the style next to the original and alone; this stays for the next style. */
function switchSplit() {
  isSplit = !isSplit;
  split(isSplit);
}

/** Shows only the original while a key or a button is held. @param {boolean} on */
function hold(on) {
  press(get("hold"), on);
  large.classList.toggle("held", on);
  large.classList.toggle("alone", on || !isSplit || !shown);
}

async function copy() {
  try {
    await navigator.clipboard.writeText(String(get("command").textContent));
    answer(get("copy"), "Copied");
  } catch {
    getSelection()?.selectAllChildren(get("command"));
    answer(get("copy"), "Selected");
  }
}

/** Saves the picture of a style. @param {number} number */
function savePicture(number) {
  const photograph = String(document.querySelector("h1 span")?.textContent).replace(/\.[^.]*$/, "");
  saveAs(pictureOf(number).src, `${photograph}-${number ? pictureOf(number).alt : "original"}.jpg`);
}

/** Saves the picture of the enlarged style. */
function save() {
  savePicture(shown);
  answer(get("save-word"), "Saved");
}

/** Whether a style is starred. @param {HTMLElement} figure */
const isStarred = (figure) => starOf(figure)?.ariaPressed === "true";

/** Shows the styles of the chosen kind that are asked for, best first, or only those that are starred. */
function filter() {
  const looks = figures.map((figure, number) => ({
    name: title(pictureOf(number).alt), aliases: figure.dataset.aliases ?? "", about: `${abouts[number]} ${figure.dataset.kinds}`, words: figure.dataset.words ?? "",
  }));
  const [found, near] = [findLooks, relatedLooks].map((find) => find(looks, finder.value).map((number) => figures[number]));
  const isAll = !finder.value.trim() && group === ALL && !onlyStarred;
  const count = figures.length - 1;
  const isWanted = (/** @type {HTMLElement} */ figure) => isAll || (figure !== figures[0] && (group === ALL || figure.dataset.kinds?.includes(group)) && (!onlyStarred || isStarred(figure)));
  const shownFigures = found.filter(isWanted);
  const related = shownFigures.length ? near.filter(isWanted) : [];
  for (const figure of figures) figure.hidden = !shownFigures.includes(figure) && !related.includes(figure);
  relatedTitle.hidden = !related.length;
  const parts = [...shownFigures, relatedTitle, ...related];
  // Moving an element takes its focus away.
  if (parts.some((part, place) => listedParts()[place] !== part)) sheet.append(...parts);
  const heading = /** @type {Text} */ (document.querySelector("h1")?.firstChild);
  heading.data = `${isAll ? "" : `${shownFigures.length} of `}${count} ${count === 1 ? "look" : "looks"}`;
  even();
  describeSearch(looks.slice(1), finder.value, !shownFigures.length, search);
}

/** What the page lists, in its order. */
const listedParts = () => [...sheet.querySelectorAll(":scope > :is(figure:not([hidden]), #related)")];

/** Arranges the thumbnails in columns. */
function even() {
  const { naturalWidth: width, naturalHeight: height } = pictureOf(0);
  document.documentElement.style.setProperty("--aspect", String(width / height || 1));
  sheet.style.setProperty("--columns", String(columnsFor(sheet.clientWidth, width / height, figures.length)));
}

/** @param {string} name */
function choose(name) {
  group = name;
  for (const button of get("groups").children) press(button, button.textContent === name);
  filter();
}

/** Shows the styles of all kinds that a text finds. @param {string} text */
function search(text) {
  finder.value = text;
  onlyStarred = false;
  press(get("starred"), false);
  choose(ALL);
  finder.focus();
}

/** Shows how many styles are starred. */
function countStars() {
  starred = [...starred.filter(isStarred), ...figures.filter((figure) => isStarred(figure) && !starred.includes(figure))];
  const count = starred.length;
  for (const [id, least] of Object.entries({ starred: 1, "compare-starred": 2, "copy-starred": 1 }))
    /** @type {HTMLButtonElement} */ (get(id)).disabled = count < least;
  get("starred").textContent = `Starred: ${count}`;
  get("compare-starred").textContent = count < 2 ? "Compare" : count <= MAX_COMPARED ? `Compare ${count}` : `Compare last ${MAX_COMPARED}`;
  get("intro").textContent = count <= MAX_COMPARED ? INTRO : `Compare: ${listed(comparedLooks().map(({ name }) => name))}`;
  if (!count) onlyStarred = false;
  press(get("starred"), onlyStarred);
  filter();
}

/** What the page says while all starred styles can be compared. */
const INTRO = String(get("intro").textContent);

/** The names of the starred styles, with commas between them. */
const starredNames = () => figures.filter(isStarred).map((figure) => figure.querySelector("img")?.alt).join(",");

/** Stars are kept under the title of the sheet. */
const STARS_KEY = `stars of ${document.title}`;

function keepStars() {
  try {
    localStorage.setItem(STARS_KEY, starredNames());
  } catch {
    // Pages from files may not keep anything.
  }
}

function restoreStars() {
  try {
    const names = (localStorage.getItem(STARS_KEY) ?? "").split(",");
    for (const [number, figure] of figures.entries()) {
      const star = starOf(figure);
      if (star) press(star, names.includes(pictureOf(number).alt));
    }
  } catch {
    // as above
  }
}

async function copyStarred() {
  const names = starredNames();
  await navigator.clipboard.writeText(names).then(() => answer(get("copy-starred"), "Copied"), () => answer(get("copy-starred"), names));
}

/** Returns what the comparison shows of a style. @param {HTMLElement} figure */
const lookOf = (figure) => {
  const number = figures.indexOf(figure);
  return { number, name: nameOf(number), about: summaryOf(abouts[number]), picture: pictureOf(number).src };
};

/** The styles that are compared: the last ones that were starred. */
const comparedLooks = () => starred.slice(-MAX_COMPARED).map(lookOf);

/** Returns the figures that the search and the chosen kind show, in their order. */
const seenFigures = () => /** @type {HTMLElement[]} */ ([...sheet.querySelectorAll(":scope > figure:not([hidden])")]);

/** Enlarges the next style that is shown, or the one before. @param {number} by */
function step(by) {
  const seen = seenFigures();
  const at = seen.indexOf(figures[shown]);
  show(figures.indexOf(seen[(at + by + seen.length) % seen.length] ?? figures[shown]));
}

const focused = () => figures.findIndex((figure) => figure.contains(document.activeElement));

const comparison = new Comparison(lookOf(figures[0]), (number) => isStarred(figures[number]), {
  star: (number) => starOf(figures[number])?.click(),
  save: savePicture,
  enlarge: show,
});

/** @type {Object<string, () => void>} */
const KEYS = {
  ArrowLeft: () => step(-1),
  ArrowRight: () => step(1),
  [SHARED_KEYS.next]: () => step(1),
  [SHARED_KEYS.compare]: switchSplit,
  [SHARED_KEYS.original]: () => hold(true),
  [SHARED_KEYS.zoom]: () => large.close(),
  [SHARED_KEYS.save]: () => get("star").click(),
  d: save,
};

for (const [number, figure] of figures.entries()) {
  figure.querySelector("button")?.addEventListener("click", () => show(number));
  for (const button of figure.querySelectorAll("button")) button.ariaLabel = `${button.ariaLabel} ${nameOf(number)}`;
  figure.querySelector("strong")?.replaceChildren(nameOf(number));
  figure.querySelector(".about")?.replaceChildren(summaryOf(abouts[number]));
}
get("previous").addEventListener("click", () => step(-1));
get("next").addEventListener("click", () => step(1));
for (const star of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll(".star"))) {
  star.append(icon("star"));
  star.tabIndex = -1; // S on the picture does the same
  star.addEventListener("click", () => {
    press(star, star.ariaPressed !== "true");
    keepStars();
    countStars();
  });
}
starOf(figures[0])?.remove();
get("star").append(icon("star"), make("span", { id: "star-word", textContent: "Star" }));
get("star").addEventListener("click", () => {
  starOf(figures[shown])?.click();
  showStar();
});
const kinds = (sheet.dataset.kinds ?? "").split(", ").filter((kind) => figures.some((figure) => figure.dataset.kinds?.includes(kind)));
get("groups").replaceChildren(...[ALL, ...kinds].map((name) => make("button", { type: "button", textContent: name, onclick: () => choose(name) })));
get("groups").hidden = kinds.length < 2;
rove(get("groups"), "button");
rove(sheet, "figure > button:first-child");
get("starred").addEventListener("click", () => {
  onlyStarred = !onlyStarred;
  countStars();
});
get("compare-starred").addEventListener("click", () => comparison.show(comparedLooks()));
get("copy-starred").addEventListener("click", copyStarred);
get("all-looks").addEventListener("click", () => search(""));
finder.addEventListener("input", filter);
finder.addEventListener("keydown", (event) => {
  const first = /** @type {HTMLElement | null} */ (sheet.querySelector(":scope > figure:not([hidden]) button"));
  if (!["Enter", "ArrowDown"].includes(event.key)) return;
  event.preventDefault();
  if (event.key === "Enter" && finder.value.trim()) first?.click();
  else first?.focus();
});
/** @type {HTMLDetailsElement} */ (get("use")).open = matchMedia("(min-width: 60rem) and (min-height: 40rem)").matches;
addEventListener("resize", even);
/** @type {HTMLImageElement} */ (get("before")).src = pictureOf(0).src;
pictureOf(0).decode().then(even, even);
restoreStars();
choose(ALL);
countStars();
get("split").addEventListener("click", switchSplit);
switchOriginal(get("hold"), () => large.classList.contains("held"), hold);
get("close").addEventListener("click", () => large.close());
get("copy").addEventListener("click", copy);
get("save").addEventListener("click", save);
get("ask").addEventListener("click", () => help.showModal());
/** Shows the original in the uppermost view. @param {boolean} on */
const holdOriginal = (on) => (comparison.dialog.open && !large.open ? comparison.hold(on) : hold(on));
addEventListener("blur", () => holdOriginal(false));
addEventListener("keyup", (event) => event.key.toLowerCase() === SHARED_KEYS.original && holdOriginal(false));
addEventListener("keydown", (event) => {
  if (event.altKey || event.ctrlKey || event.metaKey || help.open || event.target === finder) return;
  const key = event.key.length > 1 ? event.key : event.key.toLowerCase();
  if (key === SHARED_KEYS.help) help.showModal();
  else if (large.open && KEYS[key]) KEYS[key]();
  else if (!large.open && comparison.dialog.open && key === SHARED_KEYS.original) holdOriginal(true);
  else if (large.open || comparison.dialog.open) return;
  else if (key === "/") finder.focus();
  else if (key === SHARED_KEYS.zoom) show(Math.max(0, focused()));
  else if (key === SHARED_KEYS.save && focused() > 0) starOf(figures[focused()])?.click();
  else return;
  event.preventDefault();
});
large.addEventListener("close", () => hold(false));
large.addEventListener("close", () => comparison.dialog.open ? comparison.mark() : figures[shown].querySelector("button")?.focus());
switchTheme(get("theme"));
