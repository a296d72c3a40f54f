// The explorer's page: nine styles of the user's film, and nine more like the chosen one.

import { announce } from "./announce.js";
import { Lightbox } from "./lightbox.js";
import { LostNotice } from "./lost.js";
import { clock, get, icon, press } from "./elements.js";
import { NextNine } from "./next_nine.js";
import { LoadedPlans, PagePainter, ServerPainter } from "./painters.js";
import { Reference } from "./reference.js";
import { missing, Runner } from "./runner.js";
import { Connection } from "./socket.js";
import { SHARED_KEYS } from "./shared_keys.js";
import { fetchPicture, SourceFrames } from "./source_frames.js";
import { Strips } from "./strips.js";
import { switchTheme } from "./theme.js";
import { Tiles } from "./tiles.js";

/** @typedef {import("./explore_types.js").Clip} Clip */
/** @typedef {import("./explore_types.js").State} State */
/** @typedef {import("./explore_types.js").Tile} Tile */

/** Sizes at which opened looks are rendered: the shorter side in pixels. */
const OPENED_SIDES = [360, 540, 720, 1080];
/** Sizes at which tiles are rendered: the shorter side in pixels. */
const TILE_SIDES = [180, 270, 360, 540];
/** A tile may be drawn this much smaller than it is shown. */
const MIN_DRAWN_RATIO = 0.9;
/** Time for drawing in each screen refresh. */
const MAX_DRAW_MS = 12;

const options = new URLSearchParams(location.search);
/** @type {Clip | null} */
let clip = null;
/** @type {State} */
let state = { at: 0, tiles: [], taken: null, back: false, forward: false, near: 0.4, locks: [], history: [], stars: [], reference: 0 };
/** The first of two tiles to compare. @type {Tile | null} */
let compared = null;
/** Whether a new screen is being made. */
let busy = false;
/** What the user has asked for during the search, to be done as soon as it has ended. @type {(() => unknown) | null} */
let wanted = null;
/** Whether the user has cancelled the search. */
let isStopped = false;

/** Announces a message to screen readers. @param {string} text @param {boolean} [visible] whether to show it for a few seconds as well */
const say = (text, visible = true) => announce(get("message"), text, { visible });

// Renderer

const lacks = missing();
const runner = lacks.length ? null : new Runner({ onrestored: () => (stale = true) });
const asked = options.get("where");
const inPage = runner !== null && (asked ? asked === "page" : !runner.isSoftware);

const plans = inPage && runner ? new LoadedPlans(runner) : null;

/** @param {SourceFrames} source */
const painterOf = (source) => (plans ? new PagePainter(plans, source, redraw) : new ServerPainter(source, redraw));

let stale = true;
function redraw() {
  stale = true;
  if (lightbox) lightbox.dirty = true;
}

const source = new SourceFrames(redraw);
source.playing = inPage;
/** @type {Lightbox | undefined} */
let lightbox;
const painter = painterOf(source);

/** @param {number} tile @param {boolean} [isOpened] whether its picture is drawn before those of tiles @returns {import("./painters.js").Subject} */
function subjectOf(tile, isOpened = false) {
  return {
    name: String(tile),
    plan: (side, whole) => connection.ask("plan", { tile, side, whole }),
    address: (frame, side) => `tile.jpg?tile=${tile}&frame=${frame}&side=${side}${isOpened ? "&opened" : ""}`,
  };
}

/** Returns the size at which tiles are rendered: the size of the tiles on screen, or less if rendering is slow. */
function tileSide() {
  const fixed = Number(options.get("side"));
  if (TILE_SIDES.includes(fixed)) return fixed;
  const wanted = MIN_DRAWN_RATIO * Math.min(...(tiles.size ?? [1, 1])) * devicePixelRatio;
  const most = inPage ? 540 : 270;
  return TILE_SIDES.find((side) => side >= Math.min(wanted, most)) ?? most;
}

/** Returns the size at which an opened look is rendered: the size of the film, because a smaller picture has coarser marks, such as letters. */
function openedSide() {
  const own = Math.min(...(clip?.size ?? [1, 1]));
  return OPENED_SIDES.find((side) => side >= own) ?? OPENED_SIDES[OPENED_SIDES.length - 1];
}

// State from the server

const tiles = new Tiles(get("tiles"), { ontake: take, onstar: star, onenlarge: enlarge });

/** @param {Clip} next */
function takeClip(next) {
  clip = next;
  get("clip").textContent = next.name;
  document.title = `${next.name}: vidstyle explore`;
  const [width, height] = next.size;
  document.documentElement.style.setProperty("--aspect", `${width} / ${height}`);
  get("position").hidden = next.count < 2;
  press(get("play"), source.playing);
  get("moment-time").textContent = clock(next.frames[0] / next.fps);
  tiles.fit(width / height);
  painter.keep(new Set());
  source.open(next, inPage ? tileSide() : null);
  due = 0;
  prepare();
  if (state.tiles.length) get("opening").hidden = true;
  else showSource();
}

/** Shows the unchanged picture in the middle until the first styles are found. */
async function showSource() {
  const picture = await fetchPicture("glance.jpg").catch(() => null);
  get("opening").hidden = true;
  if (!picture) return;
  if (!state.tiles.length && shownTries < 5) tiles.sketch(4, picture, "Original");
  picture.close();
}

/** The number of candidates that the server has, those that are shown or were not wanted, and those before this search. */
let [tryCount, shownTries, firstTry] = [0, 0, 0];

/** Shows candidates in the empty tiles until the screen is chosen from them. */
async function showTries() {
  const first = firstTry, isWanted = () => first === firstTry && (!state.tiles.length || leaving !== null);
  while (shownTries < tryCount && isWanted()) {
    const number = shownTries++ - first, place = leaving && number >= 4 ? number + 1 : number;
    const picture = await fetchPicture(`tried.jpg?number=${first + number}`).catch(() => null);
    if (picture && isWanted() && place < 9) tiles.sketch(place, picture);
    picture?.close();
  }
}

/** How a look is chosen. */
const CLICK = `${matchMedia("(hover: none)").matches ? "Tap" : "Click"} a picture`;

/** What the page asks the user, and what follows, by the kind of the tile in the middle. @param {State} shown */
function leadOf({ tiles: shown }) {
  const [first, , , , middle] = shown;
  if (!first) return ["Finding nine looks…", rounds.before > VARIED_TRIES ? "Few suit this picture: more are tried." : "They appear one by one."];
  if (middle.kind === "chosen") return ["Your choice and eight others", `${CLICK} for nine more like it. Open one to save or render it.`];
  if (first.kind === "match") return ["Looks nearest to your picture", `${CLICK} for nine more like it. Open one to save or render it.`];
  if (tiles.drawn < 9) return ["Drawing nine looks…", "Each is blurred until it is drawn."];
  if (shown.some(({ fault }) => fault)) return ["Few looks suit this picture", "The line below a look says what is wrong with it."];
  return ["Choose the look you like best", `${CLICK} for nine more like it. Open one to save or render it.`];
}

/** Returns a sentence with the icon of the button that the words "Open one" are about. @param {string} text */
function withIcon(text) {
  const [before, after] = text.split("Open one");
  return after === undefined ? [text] : [`${before}Open one `, icon("enlarge"), after];
}

/** What screen readers were told last of a screen. */
let announced = "";

/** Tells screen readers of a screen, and once it is drawn what to do. @param {string} heading */
function announceScreen(heading) {
  const text = `Screen ${state.at + 1}: ${heading}`;
  if (busy || !state.tiles.length || text === announced) return;
  announced = text;
  say(text, false);
}

/** Shows what to do, or what is being made. @param {string[]} [lead] a heading and a sentence */
function showLead([heading, more] = leadOf(state)) {
  announceScreen(heading);
  get("hint").textContent = heading;
  get("hint-more").replaceChildren(...withIcon(more));
  get("stop").hidden = !busy || !state.tiles.length;
  if (busy || !state.tiles.length) return showProgress("");
  showProgress(`Drawing ${tiles.drawn} of 9`, tiles.drawn, 9);
  get("search").hidden = tiles.drawn === 9;
}

/** Shows the progress of what the user waits for. @param {string} note @param {number} [done] @param {number} [total] 0: unknown */
function showProgress(note, done = 0, total = 0) {
  const bar = /** @type {HTMLProgressElement} */ (get("screen-progress"));
  if (total && done < total) Object.assign(bar, { max: total, value: done });
  else bar.removeAttribute("value");
  get("search-note").textContent = note;
  get("search").hidden = false;
}

/** The number of styles of two rounds, the second for the sake of variety; more are tried only if fewer than nine are good. */
const VARIED_TRIES = 56;

/** Styles that were tried for the next screen in earlier rounds and in the present one, how many the present one has, and the part of the bar that is left for it and those after it. */
const rounds = { step: "", before: 0, now: 0, total: 0, left: 1 };

/** Shows the progress of the next screen. Another round follows if too few styles are good: as their number is not known, each takes half of what is left of the bar. @param {{step: string, done: number, total: number, shown: number}} tried */
function showTried({ step, done, total, shown }) {
  tryCount = shown;
  showTries();
  if (!busy && state.tiles.length) return;
  const isSame = step === rounds.step;
  if (rounds.now && (!isSame || !done)) Object.assign(rounds, { before: isSame ? rounds.before + rounds.total : 0, now: 0, left: rounds.left / 2 });
  Object.assign(rounds, { step, now: Math.max(done, rounds.now), total });
  const count = rounds.before + rounds.now, part = 1 - rounds.left * (1 - rounds.now / (2 * total));
  if (!state.tiles.length) showLead();
  showProgress(`${step[0].toUpperCase()}${step.slice(1)}${total ? `: ${count}` : "…"}`, total && part, total && 1);
}

/** Lets the browser's button Back return to the screen before; a screen that the user has left already is none. @param {number} screen */
function remember(screen) {
  if (wanted !== null || history.state?.screen === screen) return;
  if (state.tiles.length) history.pushState({ screen }, "");
  else history.replaceState({ screen }, "");
}

/** @param {State} next */
function takeState(next) {
  const isNew = next.at !== state.at || !state.tiles.length;
  if (leaving && !isNew) return takeStars(next.stars);
  remember(next.at);
  state = next;
  tiles.show(next.tiles, new Set(next.stars.map(({ tile }) => tile)));
  painter.keep(new Set(next.tiles.map(({ tile }) => String(tile))));
  prepare();
  showBack();
  /** @type {HTMLButtonElement} */ (get("forward")).disabled = !next.forward;
  nextNine.show(next);
  leaving = null;
  strips.showHistory(next);
  strips.showKept(next.stars);
  reference.show(next.reference);
  if (!next.tiles.length) return;
  setBusy(busy);
  showLead();
}

/** Takes the kept looks alone, while the next screen is made. @param {Tile[]} stars */
function takeStars(stars) {
  state.stars = stars;
  strips.showKept(stars);
  tiles.mark(4, leaving !== null && isKept(leaving.tile));
}

/** Enables Back if there is a previous screen, and during a search. */
function showBack() {
  /** @type {HTMLButtonElement} */ (get("back")).disabled = !(state.back || (busy && state.tiles.length));
}

function prepare() {
  const side = tileSide();
  for (const { tile } of state.tiles) {
    painter.prepare(subjectOf(tile), side).catch((error) => say(error.message));
  }
}

// Drawing

/** The frame that each tile shows. @type {number[]} */
const drawnFrames = Array(9).fill(-1);
/** The chosen tile, while the others fade until the next ones are found. @type {Tile | null} */
let leaving = null;
/** The frame that all tiles are to show. */
let due = 0;

function drawTiles() {
  requestAnimationFrame(drawTiles);
  if (lightbox?.isOpen) return lightbox.draw();
  if (!state.tiles.length || document.hidden || leaving) return;
  if (stale) drawnFrames.fill(-1);
  stale = false;
  // Looks are compared by the same frame: the next one is due when all tiles have drawn this one.
  if (drawnFrames.every((each) => each === due)) due = source.due(Math.min(...state.tiles.map(({ tile }) => painter.count(subjectOf(tile)))));
  const began = performance.now();
  for (let place = 0; place < 9 && (!inPage || performance.now() - began < MAX_DRAW_MS); place++) drawTile(place);
}

/** @param {number} place */
function drawTile(place) {
  const { canvas } = tiles.cells[place];
  if (drawnFrames[place] === due || !(isHeld ? drawSource(due, canvas) : painter.draw(subjectOf(state.tiles[place].tile), due, canvas))) return;
  drawnFrames[place] = due;
  if (isHeld) return;
  tiles.ready(place);
  if (!busy) showLead();
  strips.keepFinal(state.tiles[place].tile, canvas);
}

function togglePlay() {
  source.playing = !source.playing;
  press(get("play"), source.playing);
  painter.resume();
  if (source.playing && !inPage) say("The tiles play as soon as all frames are rendered.");
}

/** Whether the tiles show the original. */
let isHeld = false;

/** @param {boolean} on */
function hold(on) {
  if (on !== isHeld) redraw();
  isHeld = on;
}

/** Draws a frame of the source; returns whether it is loaded. @param {number} due @param {HTMLCanvasElement} canvas */
function drawSource(due, canvas) {
  const picture = source.pictures[due];
  if (picture) canvas.getContext("2d")?.drawImage(picture, 0, 0, canvas.width, canvas.height);
  return Boolean(picture);
}

// Requests

const lost = new LostNotice("vidstyle explore", [get("stage"), get("rail"), get("panel")], "Styles that you have saved are kept; looks that you only marked with the star are not.");
const connection = new Connection({
  onmessage(message) {
    if (message.clip) takeClip(message.clip);
    if (message.state) takeState({ ...state, ...message.state }); // before the first screen, it is not complete
    if (message.tried) showTried(message.tried);
    if (message.progress) lightbox?.progress(message.progress);
  },
  onpicture() {},
  onchange: (loss) => lost.show(loss),
});

const STAYING = "The present looks stay until the next ones are found.";

/** Says whether tiles can be chosen: a state arrives before the answer to the request for it. @param {boolean} on */
function setBusy(on) {
  busy = on;
  get("tiles").setAttribute("aria-busy", String(on || !state.tiles.length));
  showBack();
}

/** Stops the search for the next screen. */
function stop() {
  if (!busy || isStopped) return;
  isStopped = true;
  connection.ask("stop").catch((error) => say(error.message));
}

/** Requests another screen. @param {string} kind @param {object} [fields] @param {[string?, string?]} lead the heading and the text to show while it is made */
const ask = (kind, fields, ...lead) => change(() => connection.ask(kind, fields), ...lead);

/** Makes another screen; a search for another one is stopped before. @param {() => Promise<any>} request @param {string} [heading] names the next screen @param {string} [more] text to show until it is there @returns {Promise<void>} */
async function change(request, heading = "One moment…", more = STAYING) {
  if (busy) return afterSearch(() => change(request, heading, more));
  isStopped = false;
  Object.assign(rounds, { step: "", before: 0, now: 0, total: 0, left: 1 });
  setBusy(true);
  showLead([heading, more]);
  try {
    await request();
  } catch (error) {
    say(isStopped ? "Cancelled." : /** @type {Error} */ (error).message);
    tiles.show(state.tiles, new Set(state.stars.map(({ tile }) => tile)));
  }
  leaving = null;
  setBusy(false);
  redraw();
  showLead();
  const next = wanted;
  wanted = null;
  next?.();
}

/** Stops the search, and then does something else. @param {() => unknown} action */
function afterSearch(action) {
  wanted = action;
  stop();
}

/** Shows a screen. @param {number} screen */
function show(screen) {
  if (busy) afterSearch(() => show(screen));
  else if (screen !== state.at) ask("jump", { screen });
}

/** Shows the screen before; while the next one is being made, the present one. */
const back = () => (busy ? show(state.at) : ask("back"));

const MORE = "Finding nine more like it…";
const fresh = () => ask("fresh", {}, "Finding nine new looks…");

/** @param {number} place @returns {void} */
function take(place) {
  const chosen = state.tiles[place];
  if (!chosen) return;
  if (leaving) return say("Nine more are being found. Esc cancels the search.");
  if (busy) return afterSearch(() => state.tiles[place].tile === chosen.tile && take(place));
  leaving = chosen;
  firstTry = shownTries = tryCount;
  tiles.leave(place, isKept(leaving.tile));
  // Where tiles scroll, the choice and the progress of the search are at the top.
  get("stage").scrollTop = document.documentElement.scrollTop = 0;
  ask("like", { tile: chosen.tile }, MORE, "Your choice is in the middle.");
}

/** @param {number} tile */
const isKept = (tile) => state.stars.some((each) => each.tile === tile);

/** Keeps a tile or stops keeping it; resolves to whether it is kept. @param {number} tile @returns {Promise<boolean>} */
async function toggleStar(tile) {
  const on = !isKept(tile);
  await connection.ask("star", { tile, on });
  const text = on ? "Kept" : "No longer kept";
  say(`${text}.`, false);
  tiles.confirm(leaving ? 4 : state.tiles.findIndex((each) => each.tile === tile), text);
  return on;
}

/** Does something with the tile that has the focus or the mouse, or with the one in the middle: of tiles that fade, the chosen one. @param {(place: number) => void} action */
function withCurrent(action) {
  if (state.tiles.length) action(leaving || tiles.current < 0 ? 4 : tiles.current);
}

/** Returns the tile at a place; while the others fade, the chosen one is in the middle. @param {number} place @returns {Tile | undefined} */
const tileAt = (place) => (leaving && place === 4 ? leaving : state.tiles[place]);

/** @param {number} place */
function star(place) {
  const tile = tileAt(place);
  if (tile) toggleStar(tile.tile).catch((error) => say(error.message));
}

/** @param {number} place */
function enlarge(place) {
  const tile = tileAt(place);
  if (tile && clip) lightbox?.open(tile, clip, null, tiles.cells[place].canvas);
}

/** @param {number} place */
function compare(place) {
  const tile = tileAt(place);
  if (!tile || !clip) return;
  if (!compared || compared.tile === tile.tile) {
    compared = tile;
    say(`Press C on another tile to compare it with tile ${place + 1}.`);
    return;
  }
  lightbox?.open(tile, clip, compared);
  compared = null;
}

lightbox = new Lightbox({
  ask: (kind, fields) => connection.ask(kind, fields),
  subjectOf: (tile) => subjectOf(tile, true),
  painterOf,
  side: openedSide,
  isPlaying: () => source.playing,
  onlike: (tile) => ask("like", { tile }, MORE),
  onstar: toggleStar,
  isKept,
  say,
});

// Controls

const strips = new Strips((screen) => ask("jump", { screen }), (tile) => clip && lightbox?.open(tile, clip));
const reference = new Reference((file) => change(() => connection.upload(file, () => {}), `Finding the looks nearest to ${file.name}…`), say);
const nextNine = new NextNine((kind, fields) => connection.ask(kind, fields), say);
get("moment").addEventListener("change", async () => {
  const part = Number(/** @type {HTMLInputElement} */ (get("moment")).value);
  takeClip((await connection.ask("move", { part })).clip);
});
get("back").onclick = back;
get("forward").onclick = () => ask("forward");
addEventListener("popstate", ({ state: entry }) => entry && show(entry.screen));
get("fresh").onclick = fresh;
get("stop").onclick = stop;
const help = /** @type {HTMLDialogElement} */ (get("help"));
get("ask").onclick = () => help.showModal();
get("play").onclick = togglePlay;
get("renderer").textContent = inPage ? `Rendered by this browser on ${runner?.device}.` : "Rendered by vidstyle: this browser cannot use a GPU.";
get("switch").textContent = inPage ? "Render with vidstyle" : "Render in this browser";
get("switch").hidden = !runner;
get("switch").onclick = () => location.replace(`?where=${inPage ? "server" : "page"}`);

/** @type {Object<string, () => void>} */
const KEYS = {
  ",": back,
  Backspace: back,
  ".": () => ask("forward"),
  [SHARED_KEYS.next]: fresh,
  Escape: stop,
  m: () => reference.choose(),
  a: () => state.tiles[4]?.kind === "chosen" && ask("again", {}, MORE),
  [SHARED_KEYS.save]: () => withCurrent(star),
  [SHARED_KEYS.zoom]: () => withCurrent(enlarge),
  [SHARED_KEYS.compare]: () => withCurrent(compare),
  [SHARED_KEYS.original]: () => hold(true),
  [SHARED_KEYS.play]: togglePlay,
  [SHARED_KEYS.help]: () => help.showModal(),
};

addEventListener("keydown", (event) => {
  const target = /** @type {HTMLElement} */ (event.target);
  if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
  get("tiles").classList.add("keys");
  const isSlider = target.matches("input");
  // The keys of a number pad are arranged like the tiles.
  const pad = event.code.match(/^Numpad([1-9])$/);
  const digit = pad ? [7, 8, 9, 4, 5, 6, 1, 2, 3].indexOf(Number(pad[1])) : "123456789".indexOf(event.key);
  if (event.key.startsWith("Arrow") && !isSlider) tiles.go(event.key);
  else if (digit >= 0 && event.key.length === 1) take(digit);
  else if (KEYS[event.key] ?? KEYS[event.key.toLowerCase()]) (KEYS[event.key] ?? KEYS[event.key.toLowerCase()])();
  else return;
  event.preventDefault();
});
addEventListener("keyup", (event) => event.key === SHARED_KEYS.original && hold(false));
addEventListener("blur", () => hold(false));
addEventListener("pointermove", () => get("tiles").classList.remove("keys"));
switchTheme(get("theme"));
new ResizeObserver(() => {
  if (!clip) return;
  tiles.fit(clip.size[0] / clip.size[1]);
  prepare();
}).observe(get("stage"));
drawTiles();
