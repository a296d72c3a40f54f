/**
 * The explorer's page: nine tiles of the user's own film, and nine more like the one that is taken.
 *
 * @module
 */

import { Closer } from "./closer.js";
import { drawn, get, make } from "./elements.js";
import { LoadedPlans, PagePainter, ServerPainter } from "./painters.js";
import { missing, Runner } from "./runner.js";
import { Connection } from "./socket.js";
import { SourceFrames } from "./source_frames.js";
import { origin, rootOf, Tiles } from "./tiles.js";

/** @typedef {import("./explore_types.js").Clip} Clip */
/** @typedef {import("./explore_types.js").State} State */
/** @typedef {import("./explore_types.js").Tile} Tile */

const LOCKS = { lines: "Lines", background: "Background", colors: "Colours", steps: "Steps" };
const SIDES = [180, 270, 360, 540];
/** Milliseconds of one frame of the screen that drawing may take. */
const BUDGET = 12;

const options = new URLSearchParams(location.search);
/** @type {Clip | null} */
let clip = null;
/** @type {State} */
let state = { at: 0, tiles: [], taken: null, back: false, forward: false, near: 0.4, locks: [], history: [], stars: [] };
/** The first of two tiles to be compared. @type {Tile | null} */
let compared = null;
/** Whether a screen is under way. */
let busy = false;
/** @type {number | undefined} */
let timer;

/** Says something for a while, to screen readers too. @param {string} text @param {boolean} [shown] whether it is seen as well */
function say(text, shown = true) {
  const line = get("message");
  line.textContent = text;
  line.classList.toggle("shown", shown && Boolean(text));
  clearTimeout(timer);
  timer = setTimeout(() => line.classList.remove("shown"), 5000);
}

// Where pictures are made

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
  if (closer) closer.dirty = true;
}

const source = new SourceFrames(redraw);
/** @type {Closer | undefined} */
let closer;
const painter = painterOf(source);

/** @param {number} tile @returns {import("./painters.js").Subject} */
function subjectOf(tile) {
  return {
    name: String(tile),
    plan: (side, whole) => connection.ask("plan", { tile, side, whole }),
    address: (frame, side) => `tile.jpg?tile=${tile}&frame=${frame}&side=${side}`,
  };
}

/** The shorter side at which tiles are drawn: that of the tiles, or less where it takes long. */
function tileSide() {
  const fixed = Number(options.get("side"));
  if (SIDES.includes(fixed)) return fixed;
  const wanted = Math.min(...(tiles.size ?? [1, 1])) * devicePixelRatio;
  const most = inPage ? 540 : 270;
  return SIDES.find((side) => side >= Math.min(wanted, most)) ?? most;
}

// What is shown

const tiles = new Tiles(get("tiles"), { ontake: take, onstar: star, oncloser: look });

/** @param {Clip} next */
function takeClip(next) {
  clip = next;
  get("clip").textContent = next.name;
  document.title = `${next.name}: vidstyle explore`;
  const [width, height] = next.size;
  document.documentElement.style.setProperty("--aspect", `${width} / ${height}`);
  get("moment").hidden = next.frames.length === next.count || next.count < 2;
  tiles.fit(width / height);
  painter.keep(new Set());
  source.open(next, inPage ? tileSide() : null);
  prepare();
}

/** @param {State} next */
function takeState(next) {
  const isNew = next.at !== state.at || !state.tiles.length;
  state = next;
  tiles.show(next.tiles, new Set(next.stars.map(({ tile }) => tile)));
  painter.keep(new Set(next.tiles.map(({ tile }) => String(tile))));
  prepare();
  /** @type {HTMLButtonElement} */ (get("back")).disabled = !next.back;
  /** @type {HTMLButtonElement} */ (get("forward")).disabled = !next.forward;
  /** @type {HTMLInputElement} */ (get("near")).value = String(next.near);
  for (const name of Object.keys(LOCKS)) get(`lock-${name}`).setAttribute("aria-pressed", String(next.locks.includes(name)));
  showHistory();
  showKept();
  if (isNew && next.tiles.length) say(`Screen ${next.at + 1}: ${next.tiles[4].kind === "chosen" ? `nine like ${rootOf(next.tiles[4].name)}` : "nine styles"}`, false);
}

function prepare() {
  const side = tileSide();
  for (const { tile } of state.tiles) {
    painter.prepare(subjectOf(tile), side).catch((error) => say(error.message));
  }
}

/** A small picture of a tile. @param {number} tile */
const face = (tile) => make("img", { src: `look.jpg?tile=${tile}`, alt: "", draggable: false });

function showHistory() {
  const strip = get("seen");
  for (const [number, faces] of state.history.entries()) {
    let button = /** @type {HTMLElement | undefined} */ (strip.children[number]);
    if (!button) {
      button = make("button", { className: faces.length > 1 ? "four" : "", title: `Screen ${number + 1}`, onclick: () => ask("jump", { screen: number }) }, ...faces.map(face));
      button.setAttribute("aria-label", `Screen ${number + 1}`);
      strip.append(button);
    }
    button.setAttribute("aria-current", String(number === state.at));
    if (number === state.at) button.scrollIntoView({ block: "nearest", inline: "nearest" });
  }
}

function showKept() {
  get("none").hidden = state.stars.length > 0;
  const buttons = state.stars.map((tile) => {
    const button = make("button", { title: `${rootOf(tile.name)}: look closer`, onclick: () => clip && closer?.open(tile, clip) }, face(tile.tile));
    button.setAttribute("aria-label", `Kept: ${rootOf(tile.name)}, ${origin(tile)}`);
    return button;
  });
  get("kept").replaceChildren(...buttons);
}

// Drawing

/** The frame that each tile shows. @type {number[]} */
const placed = Array(9).fill(-1);
let next = 0;

function drawTiles() {
  requestAnimationFrame(drawTiles);
  if (closer?.isOpen) return closer.draw();
  if (!state.tiles.length || document.hidden) return;
  const began = performance.now();
  if (stale) placed.fill(-1);
  stale = false;
  for (let each = 0; each < 9 && performance.now() - began < BUDGET; each++) {
    const place = (next + each) % 9;
    const subject = subjectOf(state.tiles[place].tile);
    const due = source.due(painter.count(subject));
    if (due === placed[place]) continue;
    if (painter.draw(subject, due, tiles.cells[place].canvas)) {
      placed[place] = due;
      tiles.ready(place);
    }
    next = place + 1;
  }
}

// What is asked

const connection = new Connection({
  onmessage(message) {
    if (message.clip) takeClip(message.clip);
    if (message.state) takeState(message.state);
    if (message.progress) closer?.progress(message.progress);
  },
  onpicture() {},
  onchange(open) {
    document.body.inert = !open && clip !== null;
    if (!open && clip) say("The connection to vidstyle is lost.");
  },
});

/** Asks for another screen, one at a time. @param {string} kind @param {object} [fields] */
async function ask(kind, fields) {
  if (busy) return;
  busy = true;
  get("tiles").setAttribute("aria-busy", "true");
  try {
    await connection.ask(kind, fields);
  } catch (error) {
    say(/** @type {Error} */ (error).message);
  }
  get("tiles").setAttribute("aria-busy", "false");
  busy = false;
}

/** @param {number} place */
function take(place) {
  if (busy || !state.tiles.length) return;
  tiles.leave(place);
  placed.fill(-2);
  ask("like", { tile: state.tiles[place].tile });
}

/** @param {number} tile */
const isKept = (tile) => state.stars.some((each) => each.tile === tile);

/** @param {number} tile @returns {Promise<boolean>} */
async function toggleStar(tile) {
  const on = !isKept(tile);
  await connection.ask("star", { tile, on });
  say(on ? "Kept" : "No longer kept");
  return on;
}

/** @param {number} place */
function star(place) {
  if (state.tiles[place]) toggleStar(state.tiles[place].tile).catch((error) => say(error.message));
}

/** @param {number} place */
function look(place) {
  const tile = state.tiles[place];
  if (tile && clip) closer?.open(tile, clip);
}

/** @param {number} place */
function compare(place) {
  const tile = state.tiles[place];
  if (!tile || !clip) return;
  if (!compared || compared.tile === tile.tile) {
    compared = tile;
    say(`Press C on the tile to compare with ${place + 1}.`);
    return;
  }
  closer?.open(tile, clip, compared);
  compared = null;
}

closer = new Closer({
  ask: (kind, fields) => connection.ask(kind, fields),
  subjectOf,
  painterOf,
  side: () => (inPage ? 720 : 540),
  onlike: (tile) => ask("like", { tile }),
  onstar: toggleStar,
  isKept,
});

// Controls

for (const [name, label] of Object.entries(LOCKS)) {
  const lock = drawn("svg", { viewBox: "0 0 16 16", "aria-hidden": "true" });
  lock.append(drawn("path", { class: "shut", d: "M3.5 7.5h9v6h-9zM5.5 7.5v-2a2.5 2.5 0 0 1 5 0v2" }), drawn("path", { class: "open", d: "M3.5 7.5h9v6h-9zM5.5 7.5v-2a2.5 2.5 0 0 1 4.800-1" }));
  const button = make("button", { id: `lock-${name}`, title: `${label} stay as they are in the tile that you take` }, lock, label);
  button.setAttribute("aria-pressed", "false");
  button.onclick = () => connection.ask("lock", { name, on: button.ariaPressed !== "true" }).catch((error) => say(error.message));
  get("locks").append(button);
}
get("near").addEventListener("change", () => connection.ask("near", { part: Number(/** @type {HTMLInputElement} */ (get("near")).value) }));
get("moment").addEventListener("change", async () => {
  const part = Number(/** @type {HTMLInputElement} */ (get("moment")).value);
  takeClip((await connection.ask("move", { part })).clip);
});
get("back").onclick = () => ask("back");
get("forward").onclick = () => ask("forward");
get("fresh").onclick = () => ask("fresh");
const help = /** @type {HTMLDialogElement} */ (get("help"));
get("ask").onclick = () => help.showModal();
get("drawn").textContent = inPage ? `Drawn in this page by ${runner?.device.replace(/^ANGLE \((.*)\)$/, "$1").split(",").slice(0, 2).join(",")}.` : "Drawn by vidstyle: this browser has no graphics card to use.";
get("where").textContent = inPage ? "Drawn in this page, on your graphics card" : "Drawn by vidstyle";
get("switch").textContent = inPage ? "Let vidstyle draw" : "Draw in this page";
get("switch").hidden = !runner;
get("switch").onclick = () => location.replace(`?where=${inPage ? "server" : "page"}`);

/** @type {Object<string, () => void>} */
const KEYS = {
  b: () => ask("back"),
  Backspace: () => ask("back"),
  f: () => ask("forward"),
  n: () => ask("fresh"),
  a: () => state.tiles[4]?.kind === "chosen" && ask("again"),
  s: () => star(tiles.current),
  l: () => look(tiles.current),
  c: () => compare(tiles.current),
  p: () => (source.playing = !source.playing),
  "?": () => help.showModal(),
};

addEventListener("keydown", (event) => {
  const target = /** @type {HTMLElement} */ (event.target);
  if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
  get("tiles").classList.add("keys");
  const isSlider = target.matches("input");
  // Those of a number pad lie as the tiles do.
  const pad = event.code.match(/^Numpad([1-9])$/);
  const digit = pad ? [7, 8, 9, 4, 5, 6, 1, 2, 3].indexOf(Number(pad[1])) : "123456789".indexOf(event.key);
  if (event.key.startsWith("Arrow") && !isSlider) tiles.go(event.key);
  else if (digit >= 0 && event.key.length === 1) take(digit);
  else if (KEYS[event.key] ?? KEYS[event.key.toLowerCase()]) (KEYS[event.key] ?? KEYS[event.key.toLowerCase()])();
  else return;
  event.preventDefault();
});
addEventListener("pointermove", () => get("tiles").classList.remove("keys"));
new ResizeObserver(() => {
  if (!clip) return;
  tiles.fit(clip.size[0] / clip.size[1]);
  prepare();
}).observe(get("stage"));
drawTiles();
