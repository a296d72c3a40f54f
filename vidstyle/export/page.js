// The page of an exported style. `vidstyle.export.page` joins it with the modules that it imports.

import { announce } from "./announce.js";
import { control, isShort } from "./controls.js";
import { Divider } from "./divider.js";
import { download, get, make, oncePerFrame, press, resize } from "./elements.js";
import { missing, Runner } from "./runner.js";

/** @typedef {import("./controls.js").Described & {path: string, value: any, help: string}} Entry a control and its value */
/** @typedef {{at: number[], set: {index: number, numbers: number[], nearest: boolean}[]}} Table the effect of a control on the values of a plan */
/** @typedef {import("./runner.js").Plan} Plan */
/** @typedef {import("./runner.js").LoadedStyle} LoadedStyle */
/** @typedef {{side: number, plan: Plan & {server: string[]}, tables: Record<string, Table[]>, style?: LoadedStyle}} SizedPlan */

/**
 * @typedef {object} StyleData
 * @property {string} name
 * @property {SizedPlan[]} plans
 * @property {string[]} shaders shared by the plans, which refer to them by number
 * @property {Plan["textures"]} textures
 * @property {Entry[]} controls
 * @property {string[]} fixed paths of parameters without a control
 * @property {Record<string, Record<string, any>>} variants
 */

/** @type {StyleData} */
const data = JSON.parse(get("data").textContent ?? "");
const canvas = /** @type {HTMLCanvasElement} */ (get("picture"));
const place = /** @type {HTMLInputElement} */ (get("place"));
const detail = /** @type {HTMLSelectElement} */ (get("side"));
const options = new URLSearchParams(location.search);
const redraw = oncePerFrame(draw);
const divider = new Divider(canvas, get("divider"), redraw);

/** The video or image element to restyle; null before the first is opened. @type {HTMLVideoElement | HTMLImageElement | null} */
let source = null;
/** @type {Runner} */
let runner;
/** The loaded style for the current detail. @type {SizedPlan & {style: LoadedStyle} | null} */
let shown = null;
/** The values of the controls by path. @type {Record<string, any>} */
const values = {};
/** @type {MediaRecorder | null} */
let recorder = null;
let slow = 0;
/** A frame that takes longer is slow. */
const MAX_FRAME_MS = 70;
/** Number of consecutive slow frames after which the detail is reduced. */
const MAX_SLOW_FRAMES = 12;
const SIDES = [360, 720, 1080];

/** @param {string} text @param {number} [seconds] 0: until the next message */
const say = (text, seconds = 6) => announce(get("message"), text, { seconds });

// Values: the effect of each control was recorded when the style was exported.

/**
 * Interpolates linearly between the positions of a table, or extrapolates beyond its ends.
 * @param {number[]} at @param {number[]} numbers @param {number} position @param {boolean} nearest
 */
function interpolate(at, numbers, position, nearest) {
  let next = at.findIndex((each, number) => number > 0 && each >= position);
  if (next < 0) next = at.length - 1;
  const part = at.length > 1 ? (position - at[next - 1]) / (at[next] - at[next - 1]) : 0;
  if (nearest) return numbers[part < 0.5 ? next - 1 : next];
  return numbers[next - 1] + part * (numbers[next] - numbers[next - 1]);
}

/** Returns the positions of a value in the tables of its control. @param {Entry} entry @param {any} value @returns {number[]} */
function positionsOf({ kind, options = [] }, value) {
  if (kind === "color") return [1, 3, 5].map((from) => parseInt(value.slice(from, from + 2), 16));
  if (kind === "slider") return [value];
  return [kind === "switch" ? Number(value) : options.indexOf(value)];
}

/** Returns the values of a plan for the current controls; each control adds its difference. @param {SizedPlan} sized */
function planValues({ plan, tables }) {
  const numbers = [...plan.values];
  for (const entry of data.controls) {
    positionsOf(entry, values[entry.path]).forEach((position, axis) => {
      const { at, set } = tables[entry.path][axis];
      for (const { index, numbers: known, nearest } of set)
        numbers[index] += interpolate(at, known, position, nearest) - plan.values[index];
    });
  }
  return numbers;
}

// Drawing

/** @param {HTMLVideoElement | HTMLImageElement} picture @returns {[number, number]} */
function frameSize(picture) {
  return picture instanceof HTMLVideoElement ? [picture.videoWidth, picture.videoHeight] : [picture.naturalWidth, picture.naturalHeight];
}

/** Returns the working size: the shorter side is that of the plan. @param {[number, number]} size @param {number} side @returns {[number, number]} */
function workingSize([width, height], side) {
  const long = Math.max(side, Math.round((side * Math.max(width, height)) / Math.min(width, height)));
  return width < height ? [side, long] : [long, side];
}

function time() {
  if (!(source instanceof HTMLVideoElement)) return null;
  return source.srcObject ? performance.now() / 1000 : source.currentTime;
}

function draw() {
  if (!source || !shown || !frameSize(source)[0]) return;
  const size = workingSize(frameSize(source), shown.side);
  resize(canvas, size);
  const began = performance.now();
  if (!runner.draw(shown.style, source, canvas, { time: time(), size })) return;
  divider.paint(source, frameSize(source));
  if (source instanceof HTMLVideoElement && !source.paused) watchSpeed(performance.now() - began, shown.side);
  divider.place();
}

/** Switches to the next smaller size after many slow frames in a row. @param {number} milliseconds @param {number} side */
function watchSpeed(milliseconds, side) {
  slow = milliseconds > MAX_FRAME_MS ? slow + 1 : 0;
  const smaller = Math.max(...SIDES.filter((each) => each < side));
  if (slow < MAX_SLOW_FRAMES || smaller < 0) return;
  slow = 0;
  choose(smaller);
  say("Detail reduced to keep up with the frame rate.");
}


/** @param {HTMLVideoElement} video */
function follow(video) {
  const next = () => {
    if (source !== video) return;
    draw();
    place.value = String(video.duration ? video.currentTime / video.duration : 0);
    schedule();
  };
  const schedule = () => ("requestVideoFrameCallback" in video ? video.requestVideoFrameCallback(next) : requestAnimationFrame(next));
  schedule();
}

/** Switches to the plan for this side once it is compiled. @param {number} side */
async function choose(side) {
  detail.value = String(side);
  const found = /** @type {SizedPlan} */ (data.plans.find((each) => each.side === side));
  found.plan.textures = data.textures;
  found.plan.shaders = found.plan.shaders.map((shader) => (typeof shader === "number" ? data.shaders[shader] : shader));
  found.style ??= await runner.load(found.plan);
  shown?.style.release();
  shown = /** @type {SizedPlan & {style: LoadedStyle}} */ (found);
  shown.style.values = planValues(shown);
  shown.style.restart();
  redraw();
}

// Sources

/** @param {MediaProvider | null} stream */
function stop(stream) {
  if (stream instanceof MediaStream) stream.getTracks().forEach((track) => track.stop());
}

/** @param {HTMLVideoElement | HTMLImageElement} next */
function show(next) {
  if (source instanceof HTMLVideoElement) {
    source.pause();
    stop(source.srcObject);
  }
  source = next;
  shown?.style.restart();
  document.body.classList.remove("empty");
  get("film").hidden = !(next instanceof HTMLVideoElement && !next.srcObject);
  if (next instanceof HTMLVideoElement) follow(next);
  redraw();
}

/** @param {File} file */
async function openFile(file) {
  const src = URL.createObjectURL(file);
  try {
    if (file.type.startsWith("video/")) await openFilm(make("video", { src, loop: true, playsInline: true }));
    else {
      const picture = make("img", { src });
      await picture.decode().catch(() => {
        throw new Error("this browser cannot show this file");
      });
      show(picture);
    }
  } catch (error) {
    say(`${file.name}: ${/** @type {Error} */ (error).message}`);
  }
}

/** @param {HTMLVideoElement} video */
async function openFilm(video) {
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
      stop(stream);
      stream = await navigator.mediaDevices.getUserMedia({ video: { ...size, deviceId: { exact: chosen.deviceId } } });
    }
    const video = make("video", { srcObject: stream, muted: true, playsInline: true });
    await video.play();
    show(video);
  } catch (error) {
    say(`The camera cannot be used: ${/** @type {Error} */ (error).message}`, 0);
  }
}

/** @param {HTMLVideoElement} video */
function markPlaying(video) {
  document.body.classList.toggle("playing", !video.paused);
  document.body.classList.toggle("paused", video.paused);
}

// Controls

/** @param {string} path */
const titleOf = (path) => path.split(".").slice(-2).join(" ").replace(/#\d+/g, "").replaceAll("_", " ");

/** Adds a control; returns a function that sets its value. @param {Entry} entry */
function addControl(entry) {
  const { path, kind, help, unit } = entry;
  const ranges = data.plans.map(({ tables }) => tables[path][0].at);
  // A slider ends where a plan would need other passes.
  const ends = { low: Math.max(...ranges.map((at) => at[0])), high: Math.min(...ranges.map((at) => at[at.length - 1])) };
  const described = { ...entry, ...(kind === "slider" ? ends : {}), unit: isShort(unit) ? unit : "" };
  const shown = control(described, `value-${path}`, (value) => {
    values[path] = value;
    changed();
  });
  const label = make("label", { htmlFor: `value-${path}`, textContent: titleOf(path) });
  const row = make("div", { className: "control", title: help }, label, make("div", { className: "value" }, ...shown.inline), ...(shown.below ?? []));
  get("controls").append(row);
  const put = (/** @type {any} */ value) => {
    values[path] = value;
    shown.show(value);
  };
  put(entry.value);
  return put;
}

function changed() {
  if (shown) shown.style.values = planValues(shown);
  for (const button of get("variants").children) {
    const all = { ...initial, ...data.variants[String(button.textContent)] };
    press(button, data.controls.every(({ path }) => values[path] === all[path]));
  }
  redraw();
}

const puts = Object.fromEntries(data.controls.map((entry) => [entry.path, addControl(entry)]));
const initial = { ...values };
/** @param {Record<string, any>} wanted */
function putAll(wanted) {
  for (const [path, value] of Object.entries(wanted)) puts[path](value);
  changed();
}
for (const [name, wanted] of Object.entries(data.variants)) {
  const button = make("button", { textContent: name });
  button.onclick = () => putAll({ ...initial, ...(button.ariaPressed === "true" ? {} : wanted) });
  get("variants").append(button);
}
get("reset").onclick = () => putAll(initial);
detail.onchange = () => choose(Number(detail.value));

// Before and after

divider.listen();
get("compare").onclick = () => {
  divider.toggle();
  press(get("compare"), divider.split !== null);
};

// Saving

get("save").onclick = () => {
  draw();
  canvas.toBlob((blob) => blob && download(blob, `${data.name}.png`));
};

get("record").onclick = () => {
  if (recorder) return recorder.stop();
  const type = ["video/webm;codecs=vp9,opus", "video/webm", "video/mp4"].find((each) => window.MediaRecorder?.isTypeSupported(each));
  if (!type) return say("This browser cannot record.");
  const stream = canvas.captureStream();
  // Not every browser has captureStream of a film.
  const film = /** @type {HTMLVideoElement & {captureStream?: () => MediaStream} | null} */ (source instanceof HTMLVideoElement ? source : null);
  const heard = film?.srcObject ?? film?.captureStream?.();
  for (const track of heard instanceof MediaStream ? heard.getAudioTracks() : []) stream.addTrack(track);
  /** @type {Blob[]} */
  const parts = [];
  recorder = new MediaRecorder(stream, { mimeType: type, videoBitsPerSecond: 12e6 });
  recorder.addEventListener("dataavailable", (event) => parts.push(event.data));
  recorder.addEventListener("stop", () => {
    recorder = null;
    press(get("record"), false);
    const clip = new Blob(parts, { type });
    if (clip.size) download(clip, `${data.name}.${type.includes("mp4") ? "mp4" : "webm"}`);
    else say("Nothing was recorded.");
  });
  recorder.start(1000);
  press(get("record"), true);
  redraw();
};

// Everything else

const picker = /** @type {HTMLInputElement} */ (get("file"));
picker.onchange = () => picker.files?.[0] && openFile(picker.files[0]);
get("open").onclick = () => picker.click();
get("camera").onclick = () => openCamera();
get("again").onclick = () => document.body.classList.add("empty");
get("full").onclick = () => (document.fullscreenElement ? document.exitFullscreen() : document.body.requestFullscreen());
get("play").onclick = () => source instanceof HTMLVideoElement && (source.paused ? source.play() : source.pause());
place.oninput = () => {
  if (source instanceof HTMLVideoElement) source.currentTime = Number(place.value) * source.duration;
};
for (const kind of /** @type {const} */ (["dragover", "dragleave", "drop"])) {
  addEventListener(kind, (event) => {
    event.preventDefault();
    document.body.classList.toggle("over", kind === "dragover");
    if (kind === "drop" && event.dataTransfer?.files[0]) openFile(event.dataTransfer.files[0]);
  });
}
addEventListener("paste", (event) => event.clipboardData?.files[0] && openFile(event.clipboardData.files[0]));
/** The buttons that keys press. @type {Object<string, string>} */
const KEYS = { b: "compare", s: "save", r: "record", f: "full", " ": "play" };
addEventListener("keydown", (event) => {
  const target = /** @type {HTMLElement} */ (event.target);
  if (target.matches("input:not([type=range]), select") || event.ctrlKey || event.metaKey || event.altKey || !source) return;
  const button = KEYS[event.key] && get(KEYS[event.key]);
  if (!button || (event.key === " " && (get("film").hidden || target.matches("button")))) return;
  event.preventDefault();
  button.click();
});

async function start() {
  const lacks = missing();
  if (lacks.length) return say(`This style needs WebGL 2: ${lacks.join("; ")}.`, 0);
  document.body.classList.toggle("bare", options.has("bare"));
  runner = new Runner({ onrestored: redraw });
  const facts = [`Rendered on ${runner.device}.`];
  if (runner.isSoftware) facts.push("Software rendering: this will be slow.");
  if (data.fixed.length) facts.push(`Fixed in this file: ${data.fixed.join(", ")}.`);
  if (data.plans[0].plan.server.includes("steady")) facts.push("Temporal smoothing is only available in vidstyle render.");
  if (data.plans[0].plan.server.includes("masks")) facts.push("Masks are only available in vidstyle: here, people fill the picture.");
  get("facts").textContent = facts.join(" ");
  changed();
  await choose(SIDES.find((each) => String(each) === options.get("side")) ?? (runner.isSoftware ? 360 : 720));
  if (options.has("camera")) await openCamera(options.get("camera") ?? "");
}

start().catch((error) => say(error.message, 0));
