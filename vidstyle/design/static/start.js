// The start screen: all styles, previewed on the user's picture.

import { Doors } from "./doors.js";
import { clock, get, icon, make, press, title } from "./elements.js";
import { FilePicker } from "./file_picker.js";
import { describeSearch, findLooks, relatedLooks } from "./find_looks.js";
import { summaryOf } from "./look_summary.js";
import { glanceAt } from "./preview.js";
import { rove } from "./roving.js";

/** @typedef {import("./types.js").StyleInfo} StyleInfo */

/** The button for looks of all kinds. */
const ALL = "All";
/** The button for styles of the user. */
const MINE = "Mine";
/** The style that changes nothing. */
const PLAIN = "plain";
/** The film of `vidstyle open` before one is opened. */
const EXAMPLE = "demo";

/** The width of a tile divided by its height is the one of the film, within this range. */
const [MIN_TILE_ASPECT, MAX_TILE_ASPECT] = [0.5, 3];
/** The narrowest tiles of films in portrait, relative to the others. */
const MIN_TILE_RATIO = 0.65;
/** Lengths of the units in which the wheel is reported: pixels and lines. */
const WHEEL_UNITS_PX = [1, 18];

/** The keys of this screen, for the list of keys. @type {import("./keys.js").Shortcut[]} */
export const START_KEYS = [
  { group: "Looks", keys: ["/"], help: "Find a look", run: () => {} },
  { keys: ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"], help: "Move from look to look", run: () => {} },
  { keys: ["Enter"], help: "Open the look; in the search, the first one", run: () => {} },
  { keys: ["Tab"], help: "Move on: file, other pages, search, kinds of looks, looks", run: () => {} },
  { keys: ["Escape"], help: "Clear the search, or return to the open style", run: () => {} },
  { keys: ["?"], help: "Show this list", run: () => {} },
];

/** Whether a tile shows a style of the user. @param {HTMLElement} tile */
const isMine = (tile) => Boolean(tile.dataset.kinds?.startsWith(MINE));

/** Returns the length of a film as text. @param {import("./player.js").Clip} clip */
const lengthOf = ({ count, fps }) => (count < fps ? `${count} frames` : clock(count / fps));

/** Returns what the search knows of a tile. @param {HTMLElement} tile */
function lookOf(tile) {
  const { note = "", kinds = "", aliases = "", words = "" } = tile.dataset;
  return { name: tile.querySelector("b")?.textContent ?? "", aliases, about: `${note} ${kinds}`, words };
}

/** Opens a shipped style, a new style, a draft or a file. */
export class Start {
  /** @type {HTMLImageElement[]} */
  #pictures = [];
  /** The width of the tiles that are there or on their way; 0: none. */
  #requested = 0;
  /** The names of the styles, in the order of their pictures. @type {string[]} */
  #names = [];
  #group = ALL;
  /** All tiles in the order in which they are listed. @type {HTMLElement[]} */
  #tiles = [];
  #relatedTitle = make("h3", { textContent: "Related looks", hidden: true });
  /** The tile of a new style. @type {HTMLElement | null} */
  #new = null;
  #name = "";
  /** The address of the unchanged film, as the tiles show it. */
  #source = "";

  /**
   * @param {import("./session.js").Session} session
   * @param {(text: string) => void} say
   * @param {(name: string) => void} opened is called before another style is opened
   */
  constructor(session, say, opened) {
    this.session = session;
    this.say = say;
    this.opened = opened;
    this.root = get("start");
    this.doors = new Doors(session, () => /** @type {HTMLElement | null} */ (this.root.querySelector(".choose-file"))?.focus());
    new FilePicker(session, { onstyle: () => this.opened("file"), onopened: () => this.show(false) });
    this.finder = /** @type {HTMLInputElement} */ (get("find-look"));
    this.finder.addEventListener("input", () => this.#filter());
    this.finder.addEventListener("keydown", (event) => {
      const found = /** @type {HTMLElement | null} */ (get("tiles").querySelector(".tile:not([hidden])"));
      if (event.key === "ArrowDown") found?.focus();
      if (event.key !== "Enter" || !this.finder.value.trim()) return;
      event.preventDefault(); // else the same key would press a button of the dialog that a click may open
      found?.click();
    });
    // The bar stands above the page, which scrolls by itself.
    get("top").addEventListener("wheel", ({ deltaY, deltaMode }) => this.isOpen && this.root.scrollBy(0, deltaY * (WHEEL_UNITS_PX[deltaMode] ?? innerHeight)), { passive: true });
    rove(get("groups"), "button");
    rove(get("tiles"), ".tile");
    addEventListener("keydown", (event) => {
      document.body.classList.add("keys");
      if (event.key !== "/" || !this.isOpen || /** @type {HTMLElement} */ (event.target).matches("input")) return;
      event.preventDefault();
      this.finder.focus();
    });
    get("back").addEventListener("click", () => this.show(false));
    addEventListener("popstate", ({ state }) => {
      if (state && (state.isStart || session.state)) this.show(state.isStart);
    });
    get("all-looks").addEventListener("click", () => this.#search(""));
    session.on("kinds", (kinds) => this.#list([ALL, MINE, ...kinds]));
    session.on("styles", (styles) => this.#fill(styles));
    session.on("clip", (clip) => this.#film(clip));
    session.on("previews", (made) => this.#report(made));
    session.on("front", (front) => this.#welcome(front));
  }

  get isOpen() {
    return !this.root.hidden;
  }

  /** Keeps this screen and the opened look apart in the history of the browser, for its button Back. @param {boolean} isStart */
  #remember(isStart) {
    if (history.state?.isStart === isStart) return;
    const isFirst = !history.state;
    if (isFirst) history.replaceState({ isStart: this.session.state ? !isStart : isStart }, "");
    if (!isFirst || this.session.state) history.pushState({ isStart }, "");
  }

  /** The width of a tile on the screen, in its pixels. */
  get #tileWidth() {
    return Math.ceil((this.#pictures[0]?.clientWidth || innerWidth) * devicePixelRatio);
  }

  /** Whether a page with an open style begins with this screen: as before it was loaded again; the front page in a new tab. */
  get isShownFirst() {
    return history.state?.isStart ?? document.body.classList.contains("front");
  }

  /** Clears the search if it has a text, else returns to the open style, if there is one. */
  leave() {
    if (!this.finder.value) return this.show(false);
    this.finder.value = "";
    this.#filter();
  }

  /** Shows or hides this screen. Without an open style it stays: there is nothing behind it. @param {boolean} open */
  show(open) {
    if (!open && !this.session.state) return;
    if (open !== this.isOpen) this.#remember(open);
    this.root.hidden = !open;
    for (const id of ["work", "panel"]) get(id).inert = open;
    document.body.classList.toggle("starting", open);
    get("back").hidden = !open || !this.session.state;
    get("back").replaceChildren("Back", make("span", { textContent: ` to ${title(this.session.state?.name || "the style")}` }));
    if (!open) return;
    this.#request();
    const isExample = document.body.classList.contains("front") && this.#name === EXAMPLE;
    /** @type {HTMLElement | null} */ (this.root.querySelector(isExample ? ".choose-file" : ".tile:not([hidden])"))?.focus({ preventScroll: true });
  }

  /** @param {import("./player.js").Clip} clip */
  #film(clip) {
    this.#name = clip.name.split(/[\\/]/).at(-1) ?? "";
    get("uploading").hidden = true;
    this.#requested = 0;
    get("previews").textContent = "";
    const isExample = this.#name === EXAMPLE;
    this.doors.take(clip.count > 1, isExample);
    get("source-name").textContent = isExample ? "An example" : this.#name;
    const size = clip.size.join(" × ");
    const aspect = Math.min(Math.max(clip.size[0] / clip.size[1] || 1, MIN_TILE_ASPECT), MAX_TILE_ASPECT);
    get("tiles").style.setProperty("--tile-aspect", String(aspect));
    get("tiles").style.setProperty("--tile-ratio", String(Math.min(1, Math.max(aspect, MIN_TILE_RATIO))));
    get("source-name").title = clip.name;
    get("source-facts").textContent = clip.live ? "camera" : clip.count > 1 ? `${lengthOf(clip)}, ${size}` : size;
    for (const button of document.querySelectorAll(".choose-file")) button.textContent = isExample ? "Open a film or photograph…" : "Open another…";
    document.body.classList.toggle("opened", !isExample);
    for (const picture of this.#pictures) picture.classList.add("waiting");
    this.#markNext();
    this.#showSource(glanceAt(clip));
    if (this.isOpen) this.show(true);
  }

  /** @param {StyleInfo[]} styles */
  #fill(styles) {
    const fresh = this.#tile("New style", "Start from the unchanged film and add steps.", () => this.open("new", {}));
    fresh.classList.add("new");
    this.#new = fresh;
    fresh.prepend(make("span", { className: "blank" }, icon("plus")));
    const known = new Map(this.#names.map((name, place) => [name, this.#pictures[place]]));
    this.#pictures = [];
    this.#names = styles.map(({ name }) => name);
    const tiles = styles.map(({ name, note, kinds, aliases, words, has_name: isShipped }) => {
      const shown = (isShipped && known.get(name)) || make("img", { alt: "", className: "waiting", width: 320, height: 180 });
      this.#pictures.push(shown);
      const tile = this.#tile(title(name), summaryOf(note), (isByKeyboard) => this.open("open", { style: name }, isByKeyboard));
      tile.prepend(shown);
      Object.assign(tile.dataset, { note, kinds: [...(isShipped ? [] : [MINE]), ...kinds].join(", "), aliases, words });
      return tile;
    });
    tiles.sort((one, other) => Number(isMine(other)) - Number(isMine(one)));
    for (const button of /** @type {HTMLCollectionOf<HTMLElement>} */ (get("groups").children)) if (button.textContent === MINE) button.hidden = !tiles.some(isMine);
    const isOwn = styles.every(({ name, has_name: isShipped }) => !isShipped || known.has(name));
    if (this.#requested) this.session.ask("start", { width: this.#requested, own: isOwn });
    this.#tiles = document.body.classList.contains("front") ? [...tiles, fresh] : [fresh, ...tiles];
    get("tiles").replaceChildren();
    this.#filter();
  }

  /** Lists the kinds of looks. @param {string[]} kinds */
  #list(kinds) {
    get("groups").replaceChildren(...kinds.map((name) => make("button", { type: "button", textContent: name, onclick: () => this.#choose(name) })));
    this.#choose(ALL);
  }

  /** Shows the looks of one kind. @param {string} name */
  #choose(name) {
    this.#group = name;
    for (const button of get("groups").children) press(button, button.textContent === name);
    this.#filter();
  }

  /** Shows the looks of all kinds that a text finds. @param {string} text */
  #search(text) {
    this.finder.value = text;
    this.#choose(ALL);
    this.finder.focus();
  }

  /** Shows the looks of the chosen kind that are asked for, best first. */
  #filter() {
    const looks = this.#tiles.map(lookOf);
    const text = this.finder.value;
    const [found, related] = [findLooks, relatedLooks].map((find) => find(looks, text).map((number) => this.#tiles[number]));
    const shown = [...found, ...related];
    const parts = [...found, this.#relatedTitle, ...related, ...this.#tiles.filter((tile) => !shown.includes(tile))];
    if (parts.some((part, place) => get("tiles").children[place] !== part)) get("tiles").append(...parts);
    for (const tile of this.#tiles) tile.hidden = !shown.includes(tile) || (this.#group !== ALL && !tile.dataset.kinds?.includes(this.#group));
    const isEmpty = found.every((tile) => tile.hidden);
    this.#relatedTitle.hidden = isEmpty || related.every((tile) => tile.hidden);
    describeSearch(looks, text, isEmpty, (word) => this.#search(word));
  }

  /** @param {string} name @param {string} text @param {(isByKeyboard: boolean) => Promise<void>} chosen */
  #tile(name, text, chosen) {
    const label = make("b", { textContent: name });
    const tile = make("button", { className: "tile", type: "button" }, label, make("span", { className: "quiet", textContent: text }));
    tile.addEventListener("click", async ({ detail }) => {
      label.classList.add("spinning");
      await chosen(!detail);
      label.classList.remove("spinning");
    });
    return tile;
  }

  /** Returns the address of the tile of a style; "" if it is not there yet, and then asks for the tiles. @param {string} style */
  pictureOf(style) {
    const picture = this.#pictures[this.#names.indexOf(style)];
    if (picture && !picture.classList.contains("waiting")) return picture.src;
    if (!this.#requested) this.#request();
    return "";
  }

  /** Asks for the tiles at the width of the screen, unless they are there or on their way. */
  #request() {
    const width = this.#tileWidth;
    if (this.#requested === width) return;
    this.#requested = width;
    get("previews").textContent = "Rendering previews…";
    this.session.ask("start", { width, own: false });
  }

  /** Shows the preview of a style. @param {number} number @param {Blob} file */
  picture(number, file) {
    const picture = this.#pictures[number];
    if (!picture) return;
    picture.classList.remove("waiting");
    this.#replace(picture, URL.createObjectURL(file));
    if (this.#names[number] === PLAIN) this.#showWaiting(URL.createObjectURL(file));
    this.#markNext();
  }

  /** Marks the tile that is rendered next. */
  #markNext() {
    const next = this.#pictures.find((picture) => picture.classList.contains("waiting"));
    for (const picture of this.#pictures) picture.parentElement?.classList.toggle("next", picture === next);
  }

  /** Shows the whole unchanged film. @param {string} address */
  #showSource(address) {
    const shown = /** @type {HTMLImageElement} */ (get("source-picture"));
    shown.src = address;
    shown.hidden = false;
    this.#showWaiting(address);
  }

  /** Shows the unchanged film, out of focus, in the tiles that wait for their previews. @param {string} address */
  #showWaiting(address) {
    const before = this.#source;
    this.#source = address;
    for (const picture of this.#pictures) if (picture.classList.contains("waiting")) picture.src = this.#source;
    if (before) URL.revokeObjectURL(before);
  }

  /** @param {HTMLImageElement} picture @param {string} address */
  #replace(picture, address) {
    if (picture.src.startsWith("blob:") && picture.src !== this.#source) URL.revokeObjectURL(picture.src);
    picture.src = address;
  }

  /** Says how many previews are made. @param {{done: number, total: number}} made */
  #report({ done, total }) {
    const doing = this.#pictures.some((picture) => picture.classList.contains("waiting")) ? "Rendering" : "Sharpening";
    get("previews").textContent = done < total ? `${doing} previews: ${done} of ${total}` : this.#name === EXAMPLE ? "on an example" : `on ${this.#name}`;
  }

  /** Turns the screen into the front page. @param {{pages: string[], reveal: boolean}} front */
  #welcome({ pages }) {
    get("start-title").textContent = "Restyle a film or photograph";
    get("start-about").textContent = "Open a file, choose a look, adjust it, render. Nothing leaves this computer.";
    document.body.classList.add("front");
    if (this.#new) this.#tiles = [...this.#tiles.filter((tile) => tile !== this.#new), this.#new];
    this.#filter();
    this.doors.offer(pages);
  }

  /** @param {string} kind @param {Object<string, any>} fields @param {boolean} [isByKeyboard] */
  async open(kind, fields, isByKeyboard = false) {
    const left = this.session.state;
    this.opened(kind);
    if (!(await this.session.ask(kind, fields))) return;
    if (left?.dirty) this.say(`Your changes to “${title(left.name)}” are kept under Unsaved changes.`);
    this.show(false);
    this.finder.value = "";
    this.#filter();
    // The first control, so that the keyboard need not pass the bar; after a click, shortcuts of the page work.
    if (isByKeyboard)
      requestAnimationFrame(() => /** @type {HTMLElement | null} */ (document.querySelector("#style-tab-content :is(.chips button, input:not([type=number]))"))?.focus());
  }
}
