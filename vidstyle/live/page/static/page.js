// The picture, the status line, buttons and keys.

import {Panel} from "./panel.js";

const $ = id => document.getElementById(id);
const HOLD_MS = 300, AGAIN_MS = 1000, MESSAGE_MS = 6000, STEP = 0.1, GOING_AWAY = 1001;

const context = $("picture").getContext("2d", {alpha: false});
const times = [];
let socket, status = null, message = "", timer = 0, link = "Connecting";

const say = wish => { if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(wish)); };
const panel = new Panel(say);

function connect() {
  socket = new WebSocket(`ws://${location.host}/socket`);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => { link = ""; panel.restart(); note(); able(true); };
  socket.onmessage = ({data}) => typeof data === "string" ? hear(JSON.parse(data)) : show(data);
  socket.onclose = ({code, reason}) => {
    const ended = code === GOING_AWAY;
    link = ended ? "The session has ended" : `${reason || "vidstyle does not answer"}; trying again`;
    note();
    able(false);
    if (!ended) setTimeout(connect, AGAIN_MS);
  };
}

// Without a session nothing here does anything.
function able(on) {
  $("panel").inert = $("buttons").inert = !on;
}

function hear(news) {
  if (news.names) panel.names(news.names);
  if (news.panel) panel.show(news.panel);
  if (news.status) tell(news.status);
  if (news.error) announce(news.error, true);
  if (news.done) panel.done(news.done, news.error);
}

// A page that nobody looks at asks for no pictures.
const seen = () => new Promise(resolve => {
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
  await seen();
  if (from === socket) say({do: "shown", number});
}

function rate() {
  const now = performance.now();
  while (times.length && times[0] < now - 2000) times.shift();
  return times.length > 1 ? 1000 * (times.length - 1) / (times.at(-1) - times[0]) : 0;
}

function tell(now) {
  const facts = [
    [now.style, "the style that runs"],
    [now.size.join("×"), "width and height of the picture"],
    [`${rate().toFixed(0)} fps`, `pictures shown here each second; restyled: ${now.rate.toFixed(1)}`],
    [`${now.shown_ms.toFixed(0)} ms`, "from capture to this page, half of the pictures"],
    [`${now.dropped} dropped`, `of ${now.frames + now.dropped} pictures that came`],
    [now.degraded, "reduced to hold the rate"],
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
  const states = {waiting: `No picture from ${status?.source}; the last one is held`, ended: "The source has ended"};
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
    say({do: "bypass", on: !this.before});
  },
  end() {
    if (this.since === null) return;
    if (performance.now() - this.since > HOLD_MS) say({do: "bypass", on: this.before});
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
  s: () => panel.steadier(STEP),
  S: () => panel.steadier(-STEP),
  b: () => compare.begin(),
  p: () => $("snapshot").click(),
  r: () => say({do: "record", on: !status?.recording}),
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
$("leave").onclose = () => { if ($("leave").returnValue === "quit") say({do: "quit"}); };

connect();
