// The page of a live session: the picture, the status line, buttons and keyboard shortcuts.

import { announce } from "./announce.js";
import { Divider } from "./divider.js";
import { clock, download, get, make, press, resize, title } from "./elements.js";
import { LostNotice } from "./lost.js";
import { Panel } from "./panel.js";
import { SessionLine } from "./session_line.js";
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
 * @property {string} shown_style the style of the frame that this page shows; "": not known yet
 * @property {string} degraded
 * @property {boolean} full_size
 * @property {[string, string][]} targets
 * @property {boolean} recording
 * @property {string[]} recorded the names of finished recordings
 * @property {string} message
 */

const MIN_HOLD_MS = 300;
/** Links to a recording are offered for this time. */
const OFFER_SECONDS = 30;
const STEADY_STEP = 0.1;
const SPLIT_STEP = 0.05;

const canvas = /** @type {HTMLCanvasElement} */ (get("picture"));
const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d", { alpha: false }));
/** @type {Status | null} */
let status = null;
/** The state of the connection; "" while it is open. */
let link = "Connecting";
/** The number of connections so far. */
let connected = 0;

/** Returns the name of a style in words: "Ink, dark blue". @param {string} style */
const nameInWords = (style) => title(style.replace(/:(.*)/, (_, variant) => `, ${variant.replaceAll("-", " ")}`));
/** @param {string} text @param {boolean} [alarm] */
const say = (text, alarm = false) => announce(get("message"), text, { alarm });

const line = new SessionLine();
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
  if (text) line.end(text.split(".")[0]);
  note();
  // Without a session there is nothing to control.
  get("panel").inert = get("bar").inert = Boolean(text);
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
  line.count();
  await becomesVisible();
  if (from === connected) send("shown", { number });
}

/** @param {Status} now */
function showStatus(now) {
  line.show(now, nextName(now), !link);
  press(get("full-size"), now.full_size);
  const shown = nameInWords(now.shown_style || now.style);
  get("style-name").textContent = get("divider-look").textContent = shown;
  press(get("bypass"), now.bypass);
  press(get("record"), now.recording);
  clockRecording(now.recording);
  get("badge").hidden = !now.bypass;
  get("detail").hidden = !(now.degraded || now.full_size) || now.bypass;
  get("detail-label").textContent = now.full_size ? "Fewer frames, for full detail" : "Less detail, to keep up";
  // Other parts of the page say these.
  const isInLine = (now.degraded && now.message.includes(now.degraded)) || now.message === `style ${now.style}`;
  if (now.message !== (status?.message ?? "")) say(isInLine ? "" : withTitle(now.message, now.style));
  if (now.recorded.length > (status ?? now).recorded.length) offerRecording(now);
  followSplit(now);
  status = now;
  document.title = `${shown} · vidstyle live`;
  note();
}

/** Says that a recording is finished, with links to its film. @param {Status} now */
function offerRecording({ recorded, message }) {
  const number = recorded.length - 1, href = `rendered?of=${number}`;
  announce(get("message"), message, { seconds: OFFER_SECONDS });
  get("message").append(
    make("span", { className: "links" },
      make("a", { href, target: "_blank", className: "button", textContent: "Show" }),
      make("a", { href, download: recorded[number], className: "button", textContent: "Download" })),
  );
}

/** When the recording was first seen; 0: there is none. */
let recordedSince = 0;

/** Shows how long a recording is. @param {boolean} isRecording */
function clockRecording(isRecording) {
  recordedSince = isRecording ? recordedSince || performance.now() : 0;
  get("record-label").textContent = isRecording ? `Stop, ${clock((performance.now() - recordedSince) / 1000)}` : "Record";
}
setInterval(() => recordedSince && clockRecording(true), 1000);

/** Returns a message of the session, which may begin with the name of a style or of a file, as a sentence. @param {string} text @param {string} style */
function withTitle(text, style) {
  if (text.startsWith(style)) return nameInWords(style) + text.slice(style.length);
  return /^\S+\.\w+:/.test(text) ? text : text.replace(/^./, (first) => first.toUpperCase());
}

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

/** Returns the name of the style that will be seen next, in words; "" if the requested one is seen. @param {Status} now */
function nextName(now) {
  if (now.preparing) return nameInWords(now.preparing);
  if (now.shown_style && now.shown_style !== now.style) return nameInWords(now.style);
  return nameInWords(asked.style !== now.style && performance.now() < asked.until ? asked.style : "");
}

function note() {
  const states = { running: "", waiting: `No picture from ${status?.source}: showing the last one`, ended: "The source has ended" };
  const state = link || (status && states[status.source_state]) || "";
  const next = status ? nextName(status) : "";
  const text = state || (next && `Preparing ${next}…`);
  const element = get("note");
  if (element.textContent !== text) element.textContent = text;
  element.hidden = !text;
  get("panel").classList.toggle("preparing", Boolean(next));
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
  const file = await answer.blob();
  const { width, height } = await createImageBitmap(file);
  download(file, name);
  const notes = [status?.degraded && !status.bypass && "with less detail, to keep up", divider.split !== null && "without the comparison"].filter(Boolean);
  say(`${name} is in your downloads: ${[`${width} × ${height} pixels`, ...notes].join(", ")}.`);
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
// What a section has opened is seen, as far as it fits.
get("panel").addEventListener("toggle", ({ target }) => target instanceof HTMLDetailsElement && target.open && target.scrollIntoView({ block: "nearest", behavior: "smooth" }), true);
leave.onclose = () => leave.returnValue === "quit" && send("quit");

// The fragment "#picture" hides everything else, for programs that capture the page.
const showAlone = () => document.body.classList.toggle("alone", location.hash === "#picture");
addEventListener("hashchange", showAlone);
showAlone();
switchTheme(get("theme"));
