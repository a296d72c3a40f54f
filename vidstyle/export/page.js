// The page of an exported style. It follows runner.js in the same module.

const get = (id) => document.getElementById(id);
const data = JSON.parse(get("data").textContent);
const canvas = get("picture");
const options = new URLSearchParams(location.search);

/** The video or image element to restyle; null before the first is opened. */
let source = null;
let runner = null;
/** The loaded style for the current detail, with its plan and tables. */
let shown = null;
/** The values of the controls by path. */
const values = {};
let split = null;
let recorder = null;
let slow = 0;
/** A frame that takes longer is slow. */
const MAX_FRAME_MS = 70;
/** Number of consecutive slow frames after which the detail is reduced. */
const MAX_SLOW_FRAMES = 12;

function say(text, seconds = 6) {
  get("message").textContent = text;
  get("message").hidden = !text;
  clearTimeout(say.timer);
  if (text && seconds) say.timer = setTimeout(() => say(""), 1000 * seconds);
}

// Values: the effect of each control was recorded when the style was exported.

/** Interpolates linearly between the positions of a table, or extrapolates beyond its ends. */
function interpolate(at, numbers, position, nearest) {
  let next = at.findIndex((each, number) => number > 0 && each >= position);
  if (next < 0) next = at.length - 1;
  const part = at.length > 1 ? (position - at[next - 1]) / (at[next] - at[next - 1]) : 0;
  if (nearest) return numbers[part < 0.5 ? next - 1 : next];
  return numbers[next - 1] + part * (numbers[next] - numbers[next - 1]);
}

function positionsOf(control, value) {
  if (control.kind === "color") return [1, 3, 5].map((from) => parseInt(value.slice(from, from + 2), 16));
  if (control.kind === "slider") return [value];
  return [control.kind === "switch" ? Number(value) : control.options.indexOf(value)];
}

/** Returns the values of a plan for the current controls; each control adds its difference. */
function planValues({ plan, tables }) {
  const numbers = [...plan.values];
  for (const control of data.controls) {
    positionsOf(control, values[control.path]).forEach((position, axis) => {
      const { at, set } = tables[control.path][axis];
      for (const { index, numbers: known, nearest } of set)
        numbers[index] += interpolate(at, known, position, nearest) - plan.values[index];
    });
  }
  return numbers;
}

// Drawing

function sourceSize() {
  return [source.videoWidth || source.naturalWidth || source.width, source.videoHeight || source.naturalHeight || source.height];
}

/** Returns the working size: the shorter side is that of the plan. */
function workingSize() {
  const [width, height] = sourceSize();
  const side = shown.side;
  const long = Math.max(side, Math.round((side * Math.max(width, height)) / Math.min(width, height)));
  return width < height ? [side, long] : [long, side];
}

function time() {
  if (!(source instanceof HTMLVideoElement)) return null;
  return source.srcObject ? performance.now() / 1000 : source.currentTime;
}

function draw() {
  if (!source || !shown?.style || !sourceSize()[0]) return;
  const size = workingSize();
  if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
  const began = performance.now();
  if (!runner.draw(shown.style, source, canvas, { time: time(), size })) return;
  const context = canvas.getContext("2d");
  if (split !== null) {
    const width = Math.round(split * size[0]);
    const [own, high] = sourceSize();
    if (width) context.drawImage(source, 0, 0, split * own, high, 0, 0, width, size[1]);
  }
  if (source instanceof HTMLVideoElement && !source.paused) watchSpeed(performance.now() - began);
  placeDivider();
}

/** Switches to the next smaller size after many slow frames in a row. */
function watchSpeed(milliseconds) {
  slow = milliseconds > MAX_FRAME_MS ? slow + 1 : 0;
  const smaller = Math.max(...data.plans.map((each) => each.side).filter((side) => side < shown.side));
  if (slow < MAX_SLOW_FRAMES || smaller < 0) return;
  slow = 0;
  get("side").value = smaller;
  choose(smaller);
  say("Detail reduced to keep up with the frame rate.");
}

let pending = false;
function redraw() {
  if (pending) return;
  pending = true;
  requestAnimationFrame(() => {
    pending = false;
    draw();
  });
}

function follow(video) {
  const next = () => {
    if (source !== video) return;
    draw();
    get("place").value = video.duration ? video.currentTime / video.duration : 0;
    schedule();
  };
  const schedule = () => (video.requestVideoFrameCallback ? video.requestVideoFrameCallback(next) : requestAnimationFrame(next));
  schedule();
}

/** Switches to the plan for this side once it is compiled. */
async function choose(side) {
  const found = data.plans.find((each) => each.side === side);
  found.plan.textures = data.textures;
  if (typeof found.plan.shaders[0] === "number") found.plan.shaders = found.plan.shaders.map((number) => data.shaders[number]);
  found.style ??= await runner.load(found.plan);
  shown?.style.release();
  shown = found;
  shown.style.values = planValues(shown);
  shown.style.restart();
  redraw();
}

// Sources

function show(next) {
  if (source instanceof HTMLVideoElement) {
    source.pause();
    source.srcObject?.getTracks().forEach((track) => track.stop());
  }
  source = next;
  shown?.style.restart();
  document.body.classList.remove("empty");
  const isFilm = next instanceof HTMLVideoElement && !next.srcObject;
  get("film").hidden = !isFilm;
  if (next instanceof HTMLVideoElement) follow(next);
  redraw();
}

async function openFile(file) {
  const address = URL.createObjectURL(file);
  try {
    if (file.type.startsWith("video/")) {
      const video = Object.assign(document.createElement("video"), { src: address, loop: true, playsInline: true });
      for (const event of ["play", "pause"]) video.addEventListener(event, () => markPlaying(video));
      video.addEventListener("seeked", () => {
        shown?.style.restart();
        redraw();
      });
      await new Promise((done, fail) => {
        video.addEventListener("loadeddata", done);
        video.addEventListener("error", () => fail(new Error("this browser cannot play this file")));
      });
      show(video);
      markPlaying(video);
      await video.play().catch(() => {
        video.muted = true;
        return video.play();
      });
    } else {
      const picture = Object.assign(new Image(), { src: address });
      await picture.decode().catch(() => {
        throw new Error("this browser cannot show this file");
      });
      show(picture);
    }
  } catch (error) {
    say(`${file.name}: ${error.message}`);
  }
}

/** Starts a camera: the first, the one with this number (from 1), or the one whose name contains this text. */
async function openCamera(wanted = "") {
  try {
    if (!navigator.mediaDevices) throw new Error("this browser allows no camera in local files; serve this page from localhost or over https");
    const size = { width: { ideal: 1280 }, height: { ideal: 720 } };
    let stream = await navigator.mediaDevices.getUserMedia({ video: size });
    const cameras = (await navigator.mediaDevices.enumerateDevices()).filter((device) => device.kind === "videoinput");
    const chosen = cameras[Number(wanted) - 1] ?? cameras.find((each) => wanted && each.label.toLowerCase().includes(wanted.toLowerCase()));
    if (chosen) {
      stream.getTracks().forEach((track) => track.stop());
      stream = await navigator.mediaDevices.getUserMedia({ video: { ...size, deviceId: { exact: chosen.deviceId } } });
    }
    const video = Object.assign(document.createElement("video"), { srcObject: stream, muted: true, playsInline: true });
    await video.play();
    show(video);
  } catch (error) {
    say(`The camera cannot be used: ${error.message}`, 0);
  }
}

function markPlaying(video) {
  document.body.classList.toggle("playing", !video.paused);
  document.body.classList.toggle("paused", video.paused);
}

// Controls

function title(control) {
  const words = control.path.split(".");
  return words.slice(-2).join(" ").replace(/#\d+/g, "").replaceAll("_", " ");
}

function shownValue(control, value) {
  const digits = control.whole || Math.abs(value) >= 100 ? 0 : Math.abs(value) >= 10 ? 1 : 2;
  return control.kind === "slider" ? `${Number(value).toFixed(digits)} ${control.unit === "levels of 255" ? "" : control.unit}`.trim() : "";
}

function addControl(control) {
  const label = Object.assign(document.createElement("label"), { className: "control", title: control.help });
  const name = Object.assign(document.createElement("span"), { textContent: title(control) });
  const output = document.createElement("output");
  let input = document.createElement("input");
  if (control.kind === "slider") {
    const positions = data.plans.map((each) => each.tables[control.path][0].at);
    const [low, high] = [Math.max(...positions.map((at) => at[0])), Math.min(...positions.map((at) => at.at(-1)))];
    const step = control.whole ? 1 : Number(((high - low) / 400).toPrecision(1));
    Object.assign(input, { type: "range", min: low, max: high, step });
    label.append(name, output, input);
  } else if (control.kind === "color") {
    input.type = "color";
    label.append(name, input);
  } else if (control.kind === "switch") {
    input.type = "checkbox";
    label.append(name, input);
  } else {
    input = document.createElement("select");
    input.append(...control.options.map((option) => new Option(option)));
    label.append(name, input);
  }
  const put = (value) => {
    values[control.path] = value;
    if (control.kind === "switch") input.checked = value;
    else input.value = value;
    output.textContent = shownValue(control, value);
  };
  const taken = { slider: () => Number(input.value), switch: () => input.checked };
  input.addEventListener("input", () => {
    put((taken[control.kind] ?? (() => input.value))());
    changed();
  });
  get("controls").append(label);
  put(control.value);
  return put;
}

function changed() {
  if (shown?.style) shown.style.values = planValues(shown);
  for (const button of get("variants").children) {
    const all = { ...initial, ...data.variants[button.textContent] };
    button.setAttribute("aria-pressed", String(data.controls.every(({ path }) => values[path] === all[path])));
  }
  redraw();
}

const puts = Object.fromEntries(data.controls.map((control) => [control.path, addControl(control)]));
const initial = { ...values };
function putAll(wanted) {
  for (const [path, value] of Object.entries(wanted)) puts[path](value);
  changed();
}
for (const [name, wanted] of Object.entries(data.variants)) {
  const button = Object.assign(document.createElement("button"), { textContent: name });
  button.addEventListener("click", () => putAll({ ...initial, ...(button.ariaPressed === "true" ? {} : wanted) }));
  get("variants").append(button);
}
get("reset").addEventListener("click", () => putAll(initial));
get("side").addEventListener("change", () => choose(Number(get("side").value)));

// Before and after

function placeDivider() {
  const line = get("divider");
  line.hidden = split === null;
  if (split === null) return;
  const box = pictureBox();
  Object.assign(line.style, { left: `${box.left + split * box.width}px`, top: `${box.top}px`, height: `${box.height}px` });
}

/** Returns the rectangle of the picture within the stage. */
function pictureBox() {
  const { offsetLeft, offsetTop, offsetWidth, offsetHeight } = canvas;
  const scale = Math.min(offsetWidth / canvas.width, offsetHeight / canvas.height);
  const [width, height] = [canvas.width * scale, canvas.height * scale];
  return { left: offsetLeft + (offsetWidth - width) / 2, top: offsetTop + (offsetHeight - height) / 2, width, height };
}

function compare(on) {
  split = on ? 0.5 : null;
  get("compare").setAttribute("aria-pressed", String(on));
  redraw();
  placeDivider();
}

canvas.addEventListener("pointermove", (event) => {
  if (split === null || (event.pointerType === "mouse" && !event.buttons)) return;
  moveSplit(event);
});
canvas.addEventListener("pointerdown", (event) => {
  if (split === null) return;
  canvas.setPointerCapture(event.pointerId);
  moveSplit(event);
});
function moveSplit(event) {
  const box = pictureBox();
  const left = event.clientX - get("stage").getBoundingClientRect().left;
  split = Math.min(1, Math.max(0, (left - box.left) / box.width));
  redraw();
}
addEventListener("resize", placeDivider);
get("compare").addEventListener("click", () => compare(split === null));

// Saving

function download(blob, ending) {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: `${data.name}.${ending}` });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

get("save").addEventListener("click", () => {
  draw();
  canvas.toBlob((blob) => download(blob, "png"));
});

function record() {
  if (recorder) {
    recorder.stop();
    return;
  }
  const type = ["video/webm;codecs=vp9,opus", "video/webm", "video/mp4"].find((each) => window.MediaRecorder?.isTypeSupported(each));
  if (!type) {
    say("This browser cannot record.");
    return;
  }
  const stream = canvas.captureStream();
  const heard = source instanceof HTMLVideoElement && (source.srcObject ?? source.captureStream?.());
  for (const track of heard ? heard.getAudioTracks() : []) stream.addTrack(track);
  const parts = [];
  recorder = new MediaRecorder(stream, { mimeType: type, videoBitsPerSecond: 12e6 });
  recorder.addEventListener("dataavailable", (event) => parts.push(event.data));
  recorder.addEventListener("stop", () => {
    recorder = null;
    get("record").setAttribute("aria-pressed", "false");
    const clip = new Blob(parts, { type });
    if (clip.size) download(clip, type.includes("mp4") ? "mp4" : "webm");
    else say("Nothing was recorded.");
  });
  recorder.start(1000);
  get("record").setAttribute("aria-pressed", "true");
  redraw();
}
get("record").addEventListener("click", record);

// Everything else

const picker = get("file");
picker.addEventListener("change", () => picker.files[0] && openFile(picker.files[0]));
get("open").addEventListener("click", () => picker.click());
get("camera").addEventListener("click", () => openCamera());
get("again").addEventListener("click", () => document.body.classList.add("empty"));
get("full").addEventListener("click", () => (document.fullscreenElement ? document.exitFullscreen() : document.body.requestFullscreen()));
get("play").addEventListener("click", () => (source.paused ? source.play() : source.pause()));
get("place").addEventListener("input", () => {
  source.currentTime = get("place").value * source.duration;
});
for (const kind of ["dragover", "dragleave", "drop"]) {
  addEventListener(kind, (event) => {
    event.preventDefault();
    document.body.classList.toggle("over", kind === "dragover");
    if (kind === "drop" && event.dataTransfer.files[0]) openFile(event.dataTransfer.files[0]);
  });
}
addEventListener("paste", (event) => event.clipboardData.files[0] && openFile(event.clipboardData.files[0]));
addEventListener("keydown", (event) => {
  if (event.target.matches("input:not([type=range]), select") || event.ctrlKey || event.metaKey || event.altKey || !source) return;
  const keys = { b: "compare", s: "save", r: "record", f: "full", " ": "play" };
  const button = keys[event.key] && get(keys[event.key]);
  if (!button || (event.key === " " && (get("film").hidden || event.target.matches("button")))) return;
  event.preventDefault();
  button.click();
});

async function start() {
  const lacks = missing();
  if (lacks.length) {
    say(`This style needs WebGL 2: ${lacks.join("; ")}.`, 0);
    return;
  }
  document.body.classList.toggle("bare", options.has("bare"));
  runner = new Runner({ onrestored: redraw });
  const side = [360, 720, 1080].find((each) => String(each) === options.get("side")) ?? (runner.isSoftware ? 360 : 720);
  get("side").value = side;
  const facts = [`Rendered on ${runner.device.replace(/^ANGLE \((.*)\)$/, "$1").split(",").slice(0, 2).join(",")}.`];
  if (runner.isSoftware) facts.push("Software rendering: this will be slow.");
  if (data.fixed.length) facts.push(`Fixed in this file: ${data.fixed.join(", ")}.`);
  if (data.plans[0].plan.server.includes("steady")) facts.push("Temporal smoothing is only available in vidstyle render.");
  get("facts").textContent = facts.join(" ");
  changed();
  await choose(side);
  if (options.has("camera")) await openCamera(options.get("camera"));
}

start().catch((error) => say(error.message, 0));
