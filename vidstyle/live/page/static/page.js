// The page of a live session: the picture, the status line, buttons and keyboard shortcuts.

import { announce } from "./announce.js";
import { Divider } from "./divider.js";
import { download, get, make, press, resize, title } from "./elements.js";
import { LostNotice } from "./lost.js";
import { Panel } from "./panel.js";
import { SHARED_KEYS } from "./shared_keys.js";
import { Connection } from "./socket.js";
import { switchTheme } from "./theme.js";

/**
 * The status of the session, as the server reports it.
 * @typedef {object} Status
 * @property {string} style
 * @property {string} preparing the style that will run next; "": none
 * @property {boolean} bypass
 * @property {number} split
 * @property {string} source
 * @property {"running" | "waiting" | "ended"} source_state
 * @property {[number, number]} size
 * @property {number} frames
 * @property {number} dropped
 * @property {number} rate
 * @property {number} shown_ms
 * @property {string} degraded
 * @property {boolean} full_size
 * @property {[string, string][]} targets
 * @property {boolean} recording
 * @property {string} message
 */

const MIN_HOLD_MS = 300;
const RATE_MS = 2000;
/** The rate is measured over at least so many frames. */
const MIN_RATE_FRAMES = 4;
/** After so many times the usual interval without a frame, the page waits for one; at least this time. */
const [MAX_INTERVALS, MIN_WAIT_MS] = [4, 5000];
const STEADY_STEP = 0.1;
const SPLIT_STEP = 0.05;

const canvas = /** @type {HTMLCanvasElement} */ (get("picture"));
const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d", { alpha: false }));
/** When the last frames were shown. @type {number[]} */
const times = [];
/** @type {Status | null} */
let status = null;
/** The state of the connection; "" while it is open. */
let link = "Connecting";
/** The number of connections so far. */
let connected = 0;

/** @param {string} text @param {boolean} [alarm] */
const say = (text, alarm = false) => {
  get("message").title = text; // the line may be too short for it
  announce(get("message"), text, { alarm });
};

const lost = new LostNotice("vidstyle live", []);
const connection = new Connection({
  onmessage(message) {
    if (message.names) panel.names(message.names);
    if (message.looks) panel.looks.describe(message.looks);
    if (message.panel) {
      panel.show(message.panel);
      if (status && message.panel.name !== baseOf(status.style)) announceStyle(message.panel.name);
    }
    if (message.status) showStatus(message.status);
  },
  onpicture: ({ number, file }) => show(number, file),
  onchange(loss) {
    if (!loss) {
      connected += 1;
      sendSplit();
    }
    lost.show(loss);
    setLink(loss ? "No connection" : "");
  },
  onend: () => setLink("The session has ended. Start “vidstyle live” again to continue."),
});

/** Sends a message; resolves to whether it succeeded. @param {string} kind @param {object} [fields] */
async function send(kind, fields) {
  try {
    await connection.ask(kind, fields);
    return true;
  } catch (error) {
    if (!link) say(/** @type {Error} */ (error).message, true);
    return false;
  }
}

const panel = new Panel(send, (style) => announceStyle(style));

/** The server divides the picture. */
const divider = new Divider(canvas, get("divider"), () => sendSplit());
divider.listen();
const split = { isSending: false, sent: 0 };

/** Sends the place of the divider, one message at a time. */
async function sendSplit() {
  const at = divider.split ?? 0;
  if (split.isSending || (at === split.sent && connected <= 1)) return;
  split.isSending = true;
  split.sent = at;
  const isSent = await send("compare", { at });
  split.isSending = false;
  if (isSent && at !== (divider.split ?? 0)) sendSplit();
}

function toggleSplit() {
  divider.toggle();
  press(get("compare"), divider.split !== null);
}

/** @param {string} text */
function setLink(text) {
  link = text;
  if (text) {
    get("sentence").textContent = text.split(".")[0];
    get("figures").classList.remove("running");
  }
  note();
  // Without a session there is nothing to control.
  get("panel").inert = get("buttons").inert = Boolean(text);
}

/** Resolves once the page is visible: a hidden page requests no pictures. @returns {Promise<unknown>} */
function becomesVisible() {
  if (!document.hidden) return Promise.resolve();
  return new Promise((done) => document.addEventListener("visibilitychange", done, { once: true }));
}

/** @param {number} number @param {Blob} file */
async function show(number, file) {
  const from = connected;
  const picture = await createImageBitmap(file);
  const { width, height } = picture;
  if (width !== canvas.width || height !== canvas.height) {
    resize(canvas, [width, height]);
    divider.place();
  }
  context.drawImage(picture, 0, 0);
  picture.close();
  times.push(performance.now());
  await becomesVisible();
  if (from === connected) send("shown", { number });
}

/** Returns the number of frames shown per second; 0 before the second one. */
function rate() {
  const now = performance.now();
  while (times.length > MIN_RATE_FRAMES && times[0] < now - RATE_MS) times.shift();
  return times.length > 1 ? (1000 * (times.length - 1)) / (times[times.length - 1] - times[0]) : 0;
}

/** The rate that is said stays until the measured one differs by this part of it. */
const MIN_RATE_CHANGE = 0.3;
let saidRate = 0;

/** Returns the number of frames shown per second, which does not change all the time. */
function steadyRate() {
  const measured = rate();
  if (Math.abs(measured - saidRate) > MIN_RATE_CHANGE * saidRate) saidRate = measured;
  return saidRate;
}

/** Whether the next frame is late, compared with those before. */
function isLate() {
  const usual = rate() ? 1000 / rate() : 0;
  return performance.now() - times[times.length - 1] > Math.max(MIN_WAIT_MS, MAX_INTERVALS * usual);
}

/** Returns how many captured frames are shown, in words; "" if almost all are. @param {Status} now */
function shareOf({ frames, dropped }) {
  const part = frames / Math.max(1, frames + dropped);
  return part > 0.98 ? "" : `${Math.round(100 * part)} % of the frames`;
}

/** @param {number} shown frames per second */
function inWords(shown) {
  if (shown >= 1.5) return `${Math.round(shown)} frames per second`;
  return shown > 0.75 ? "1 frame per second" : `a frame every ${shown > 0 ? Math.round(1 / shown) : "few"} seconds`;
}

/** Below this number of frames per second a film does not look like one. */
const MIN_SMOOTH_RATE = 12;

/** Says how the session goes. @param {Status} now */
function sentenceOf(now) {
  if (now.source_state === "ended") return "Ended";
  const shown = steadyRate();
  const next = nextStyle(now);
  if (next) return `Preparing ${title(next)}; the picture may stand still`;
  if (!times.length) return "Starting…";
  if (isLate()) return "Waiting for the next picture";
  if (!shown) return "Live";
  if (shown < MIN_SMOOTH_RATE && times.length && shareOf(now)) return `Live, ${inWords(shown)}, others skipped`;
  return `Live, ${inWords(shown)}`;
}

/** @param {Status} now */
function showStatus(now) {
  const facts = [
    ["Size", now.size.join(" × "), "width and height of the picture"],
    ["Shown here", inWords(steadyRate()), `restyled: ${now.rate.toFixed(1)}`],
    ["Delay", `${now.shown_ms.toFixed(0)} ms`, "median latency from capture to this page"],
    ["Captured", shareOf(now) && `${shareOf(now)} shown`, `${now.dropped} of ${now.frames + now.dropped} captured frames were left out to stay live`],
    ["Detail", now.degraded, "a smaller picture is restyled and enlarged, to keep the frame rate"],
    ...now.targets.filter(([name]) => name !== "page").map(([name, text]) => [name, text, "another target"]),
  ];
  get("sentence").textContent = sentenceOf(now);
  get("figures").classList.toggle("running", now.source_state === "running" && !link);
  get("line").replaceChildren(...facts.filter(([, text]) => text).map(([name, text, title]) => make("span", { title }, make("span", { className: "quiet", textContent: name }), text)));
  const size = get("full-size");
  press(size, now.full_size);
  get("style-name").textContent = title(now.style);
  press(get("bypass"), now.bypass);
  press(get("record"), now.recording);
  get("record-label").textContent = now.recording ? "Stop" : "Record";
  get("badge").hidden = !now.bypass;
  get("detail").hidden = !(now.degraded || now.full_size) || now.bypass;
  get("detail-label").textContent = now.full_size ? "Fewer frames" : "Less detail, to keep up";
  // Other parts of the page say these.
  const isInLine = (now.degraded && now.message.includes(now.degraded)) || now.message === `style ${now.style}`;
  if (now.message !== (status?.message ?? "")) say(isInLine ? "" : withTitle(now.message, now.style));
  followSplit(now);
  status = now;
  document.title = `${title(now.style)} · vidstyle live`;
  note();
}

/** Returns a message of the session, which may begin with the name of a style, as a sentence. @param {string} text @param {string} style */
const withTitle = (text, style) => (text.startsWith(style) ? title(style) + text.slice(style.length) : text.replace(/^./, (first) => first.toUpperCase()));

/** Shows where another browser divides the picture. @param {Status} now */
function followSplit(now) {
  const other = now.split || null;
  if (split.isSending || now.split === split.sent || divider.split === other) return;
  split.sent = now.split;
  Object.assign(divider, { split: other });
  divider.place();
  press(get("compare"), other !== null);
}

/** The look that was chosen here last, and until when it is announced before the session reports it. */
const asked = { style: "", until: 0 };
/** A session takes a request with its next frame. */
const MAX_REQUEST_MS = 1500;

/** @param {string} style */
function announceStyle(style) {
  Object.assign(asked, { style, until: performance.now() + MAX_REQUEST_MS });
  note();
}

/** Returns the name of a style without its variant. @param {string} style */
const baseOf = (style) => style.split(":")[0];

/** Returns the style that will run next; "" if none is being prepared. @param {Status} now */
const nextStyle = (now) => now.preparing || (asked.style !== now.style && performance.now() < asked.until ? asked.style : "");

function note() {
  const states = { running: "", waiting: `No picture from ${status?.source}: showing the last one`, ended: "The source has ended" };
  const state = link || (status && states[status.source_state]) || "";
  const next = status ? nextStyle(status) : "";
  const text = state || (next && `Preparing ${title(next)}…`);
  const line = get("note");
  if (line.textContent !== text) line.textContent = text;
  line.hidden = !text;
  canvas.style.opacity = state ? "0.6" : "1";
}

/** A hold shows the source until it ends; a brief press toggles. */
const compare = {
  /** @type {number | null} */
  since: null,
  before: false,
  begin() {
    if (this.since !== null) return;
    this.since = performance.now();
    this.before = Boolean(status?.bypass);
    send("bypass", { on: !this.before });
  },
  end() {
    if (this.since === null) return;
    if (performance.now() - this.since > MIN_HOLD_MS) send("bypass", { on: this.before });
    this.since = null;
  },
};

function fill() {
  if (document.fullscreenElement) document.exitFullscreen();
  else get("stage").requestFullscreen?.().catch((error) => say(error.message, true));
}

get("snapshot").addEventListener("click", async (event) => {
  event.preventDefault();
  const answer = await fetch("picture.png").catch(() => null);
  const name = /filename="(.*)"/.exec(answer?.headers.get("content-disposition") ?? "")?.[1];
  if (!answer?.ok || !name) return say("The picture cannot be saved.", true);
  download(await answer.blob(), name);
  say("The picture is in your downloads.");
});

const leave = /** @type {HTMLDialogElement} */ (get("leave"));
const help = /** @type {HTMLDialogElement} */ (get("help"));
/** Moves the divider, if there is one. @param {number} by */
const moveDivider = (by) => divider.split !== null && divider.move(divider.split + by);

/** @type {Object<string, () => unknown>} */
const KEYS = {
  ArrowLeft: () => moveDivider(-SPLIT_STEP),
  ArrowRight: () => moveDivider(SPLIT_STEP),
  [SHARED_KEYS.compare]: toggleSplit,
  "/": () => panel.looks.focus(),
  [SHARED_KEYS.next]: () => panel.choose("next"),
  "+": () => panel.changeSteady(STEADY_STEP),
  "-": () => panel.changeSteady(-STEADY_STEP),
  [SHARED_KEYS.original]: () => compare.begin(),
  [SHARED_KEYS.save]: () => get("snapshot").click(),
  r: () => send("record", { on: !status?.recording }),
  [SHARED_KEYS.full]: fill,
  q: () => leave.showModal(),
  [SHARED_KEYS.help]: () => help.showModal(),
};

/** Returns the key of an event; letters with the shift key are the same. @param {KeyboardEvent} event */
const keyOf = ({ key }) => (key.length > 1 ? key : key.toLowerCase());

addEventListener("keydown", (event) => {
  const target = /** @type {HTMLElement} */ (event.target);
  const isWriting = target.matches("select, textarea, input[type=number], input[type=search], dialog *");
  if (event.ctrlKey || event.altKey || event.metaKey || isWriting) return;
  const holds = target.id === "bypass" && [" ", "Enter"].includes(event.key);
  const key = keyOf(event);
  const isArrow = key.startsWith("Arrow");
  const action = holds ? KEYS[SHARED_KEYS.original] : KEYS[key];
  if (!action || (isArrow && (divider.split === null || target.matches("input")))) return;
  event.preventDefault();
  if (!event.repeat || isArrow || "+-".includes(key)) action();
});
addEventListener("keyup", (event) => [SHARED_KEYS.original, " ", "Enter"].includes(keyOf(event)) && compare.end());
get("bypass").onpointerdown = (event) => event.button === 0 && compare.begin();
for (const kind of ["blur", "pointerup", "pointercancel"]) addEventListener(kind, () => compare.end());
addEventListener("pointerdown", ({ target }) => get("figures").contains(/** @type {Node} */ (target)) || get("figures").removeAttribute("open"));
get("compare").onclick = toggleSplit;
get("record").onclick = KEYS.r;
get("full-size").onclick = () => send("keep_size", { on: !status?.full_size });
get("full").onclick = canvas.ondblclick = fill;
get("ask").onclick = KEYS["?"];
leave.onclose = () => leave.returnValue === "quit" && send("quit");

// The fragment "#picture" hides everything else, for programs that capture the page.
const showAlone = () => document.body.classList.toggle("alone", location.hash === "#picture");
addEventListener("hashchange", showAlone);
showAlone();
switchTheme(get("theme"));
