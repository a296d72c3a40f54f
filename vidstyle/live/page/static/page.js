// The picture, the status line, buttons and keyboard shortcuts.

import {Panel} from "./panel.js";

const $ = id => document.getElementById(id);
const MIN_HOLD_MS = 300, RECONNECT_MS = 1000, MESSAGE_MS = 6000, STEADY_STEP = 0.1, GOING_AWAY_CODE = 1001;

const context = $("picture").getContext("2d", {alpha: false});
const times = [];
let socket, status = null, message = "", timer = 0, link = "Connecting";

const send = message => { if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message)); };
const panel = new Panel(send);

function connect() {
  socket = new WebSocket(`ws://${location.host}/socket`);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => { link = ""; panel.restart(); note(); enable(true); };
  socket.onmessage = ({data}) => typeof data === "string" ? receive(JSON.parse(data)) : show(data);
  socket.onclose = ({code, reason}) => {
    const ended = code === GOING_AWAY_CODE;
    link = ended ? "The session has ended" : `${reason || "Connection to vidstyle lost"}. Reconnecting…`;
    note();
    enable(false);
    if (!ended) setTimeout(connect, RECONNECT_MS);
  };
}

// Without a session there is nothing to control.
function enable(on) {
  $("panel").inert = $("buttons").inert = !on;
}

function receive(message) {
  if (message.names) panel.names(message.names);
  if (message.panel) panel.show(message.panel);
  if (message.status) showStatus(message.status);
  if (message.error) announce(message.error, true);
  if (message.done) panel.done(message.done, message.error);
}

// A hidden page requests no pictures.
const visible = () => new Promise(resolve => {
  if (!document.hidden) return resolve();
  document.addEventListener("visibilitychange", resolve, {once: true});
});

async function show(data) {
  const from = socket;
  const number = Number(new DataView(data).getBigUint64(0));
  const picture = await createImageBitmap(new Blob([new Uint8Array(data, 8)], {type: "image/jpeg"}));
  const canvas = $("picture");
  if (canvas.width !== picture.width || canvas.height !== picture.height)
    Object.assign(canvas, {width: picture.width, height: picture.height});
  context.drawImage(picture, 0, 0);
  picture.close();
  times.push(performance.now());
  await visible();
  if (from === socket) send({do: "shown", number});
}

function rate() {
  const now = performance.now();
  while (times.length && times[0] < now - 2000) times.shift();
  return times.length > 1 ? 1000 * (times.length - 1) / (times.at(-1) - times[0]) : 0;
}

function showStatus(now) {
  const facts = [
    [now.style, "style"],
    [now.size.join("×"), "width and height of the picture"],
    [`${rate().toFixed(0)} fps`, `frames shown per second on this page; restyled: ${now.rate.toFixed(1)}`],
    [`${now.shown_ms.toFixed(0)} ms`, "median latency from capture to this page"],
    [`${now.dropped} dropped`, `of ${now.frames + now.dropped} captured frames`],
    [now.degraded, "reduced to keep the frame rate"],
    ...now.targets.filter(([name]) => name !== "page").map(target => [target.join(": "), "another target"]),
  ];
  $("line").replaceChildren(...facts.filter(([text]) => text).map(([textContent, title]) =>
    Object.assign(document.createElement("span"), {textContent, title})));
  press($("bypass"), now.bypass);
  press($("record"), now.recording);
  $("badge").hidden = !now.bypass;
  if (now.message !== message) announce(message = now.message);
  status = now;
  document.title = `${now.style} · vidstyle live`;
  note();
}

function press(button, on) {
  if (button.getAttribute("aria-pressed") !== String(on)) button.setAttribute("aria-pressed", on);
}

function note() {
  const states = {waiting: `No picture from ${status?.source}: showing the last one`, ended: "The source has ended"};
  const text = link || (status && states[status.source_state]) || "";
  if ($("note").textContent !== text) $("note").textContent = text;
  $("note").hidden = !text;
  $("picture").style.opacity = text ? 0.6 : 1;
}

function announce(text, alarm = false) {
  $("message").textContent = text;
  $("message").classList.toggle("alarm", alarm);
  clearTimeout(timer);
  timer = setTimeout(() => { $("message").textContent = ""; }, MESSAGE_MS);
}

const compare = {
  since: null,
  begin() {
    if (this.since !== null) return;
    this.since = performance.now();
    this.before = Boolean(status?.bypass);
    send({do: "bypass", on: !this.before});
  },
  end() {
    if (this.since === null) return;
    if (performance.now() - this.since > MIN_HOLD_MS) send({do: "bypass", on: this.before});
    this.since = null;
  },
};

function fill() {
  if (document.fullscreenElement) document.exitFullscreen();
  else $("stage").requestFullscreen?.().catch(error => announce(error.message, true));
}

const isWriting = target => target.matches("select, textarea, input[type=number], dialog *");
const actions = {
  n: () => panel.choose({do: "next"}),
  s: () => panel.changeSteady(STEADY_STEP),
  S: () => panel.changeSteady(-STEADY_STEP),
  b: () => compare.begin(),
  p: () => $("snapshot").click(),
  r: () => send({do: "record", on: !status?.recording}),
  f: fill,
  q: () => $("leave").showModal(),
  "?": () => $("help").showModal(),
};

addEventListener("keydown", event => {
  if (event.ctrlKey || event.altKey || event.metaKey || isWriting(event.target)) return;
  const holds = event.target.id === "bypass" && [" ", "Enter"].includes(event.key);
  const action = holds ? actions.b : actions[event.key];
  if (!action) return;
  event.preventDefault();
  if (!event.repeat || event.key.toLowerCase() === "s") action();
});
addEventListener("keyup", event => { if (["b", " ", "Enter"].includes(event.key)) compare.end(); });
addEventListener("blur", () => compare.end());
$("bypass").onpointerdown = event => { if (event.button === 0) compare.begin(); };
addEventListener("pointerup", () => compare.end());
addEventListener("pointercancel", () => compare.end());
$("record").onclick = actions.r;
$("full").onclick = fill;
$("picture").ondblclick = fill;
$("ask").onclick = actions["?"];
$("leave").onclose = () => { if ($("leave").returnValue === "quit") send({do: "quit"}); };

// The fragment "#picture" hides everything else, for programs that capture the page.
const showAlone = () => document.body.classList.toggle("alone", location.hash === "#picture");
addEventListener("hashchange", showAlone);
showAlone();
connect();
