// The large picture of a page: one style, its controls, before and after, and saving.

import { announce } from "./announce.js";
import { Divider } from "./divider.js";
import { download, get, make, oncePerFrame, press, resize } from "./elements.js";
import { planValues } from "./plan_values.js";
import { record } from "./recording.js";
import { SHARED_KEYS } from "./shared_keys.js";
import { addressOf } from "./shared_link.js";
import { Source } from "./source.js";
import { StylePanel } from "./style_panel.js";
import { switchTheme } from "./theme.js";

/** @typedef {import("./plan_values.js").SizedPlan} SizedPlan */
/** @typedef {import("./runner.js").LoadedStyle} LoadedStyle */
/** @typedef {import("./runner.js").Runner} Runner */

/**
 * @typedef {object} StyleData
 * @property {string} name
 * @property {SizedPlan[]} plans
 * @property {import("./plan_values.js").Entry[]} controls
 * @property {string[]} fixed paths of parameters without a control
 * @property {boolean} focus whether the style has finer detail in faces elsewhere
 * @property {Record<string, Record<string, any>>} variants
 */

/** A frame that takes longer is slow. */
const MAX_FRAME_MS = 70;
/** Number of consecutive slow frames after which the detail is reduced. */
const MAX_SLOW_FRAMES = 12;
const SIDES = [360, 720, 1080];
/** Photographs are shown in full detail: faces lose their features in a smaller picture. */
const PHOTOGRAPH_SIDE = SIDES[2];
/** Without a GPU, a photograph is drawn in full detail once its values have not changed for this time. */
const REFINE_MS = 500;
/** The buttons that keys press. @type {Object<string, string>} */
const KEYS = {
  [SHARED_KEYS.compare]: "compare", [SHARED_KEYS.save]: "save", [SHARED_KEYS.full]: "full", [SHARED_KEYS.play]: "play", " ": "play", r: "record", [SHARED_KEYS.help]: "ask",
};

/** Returns the working size: the shorter side is that of the plan. @param {[number, number]} size @param {number} side @returns {[number, number]} */
export function workingSize([width, height], side) {
  const long = Math.max(side, Math.round((side * Math.max(width, height)) / Math.min(width, height)));
  return width < height ? [side, long] : [long, side];
}

/** Returns a style that is loaded for one working size. @param {Runner} runner @param {SizedPlan} sized @returns {Promise<SizedPlan & {style: LoadedStyle}>} */
export async function loadStyle(runner, sized) {
  sized.style ??= await runner.load(sized.plan);
  return /** @type {SizedPlan & {style: LoadedStyle}} */ (sized);
}

/** Shows a picture in a style, in the elements of `stage.html`. */
export class Viewer {
  canvas = /** @type {HTMLCanvasElement} */ (get("picture"));
  /** @type {StyleData | null} */
  data = null;
  /** @type {StylePanel | null} */
  panel = null;
  #place = /** @type {HTMLInputElement} */ (get("place"));
  #detail = /** @type {HTMLSelectElement} */ (get("side"));
  redraw = oncePerFrame(() => this.#drawSoon());
  #divider = new Divider(this.canvas, get("divider"), this.redraw);
  source = new Source({
    onopen: () => this.#opened(),
    onphotograph: () => this.#isChosen || this.#choose(PHOTOGRAPH_SIDE),
    onframe: () => this.#framed(),
    onjump: () => this.#shown?.style.restart(),
    report: (text, seconds) => this.say(text, seconds),
  });
  /** The loaded style for the current detail. @type {(SizedPlan & {style: LoadedStyle}) | null} */
  #shown = null;
  /** @type {MediaRecorder | null} */
  #recorder = null;
  #slow = 0;
  /** Whether the user has chosen the detail. */
  #isChosen = false;
  /** The working size that is shown, or will be once it is compiled. */
  #wanted = 0;
  #refining = 0;
  /** Whether the original is shown while a button or key is held. */
  #held = false;
  /** Is called when a value of a control has changed. @type {() => void} */
  onchange = () => {};

  /** @param {Runner} runner */
  constructor(runner) {
    this.runner = runner;
    this.#detail.value = String(this.#filmSide);
    this.#divider.listen();
    this.#listen();
    switchTheme(get("theme"));
  }

  /** Shows a message. @param {string} text @param {number} [seconds] 0: until the next message */
  say(text, seconds = 6) {
    announce(get("message"), text, { seconds });
  }

  /** The detail that a film starts with. */
  get #filmSide() {
    return this.runner.isSoftware ? SIDES[0] : SIDES[1];
  }

  /** The working size: the length of the shorter side. */
  get side() {
    return Number(this.#detail.value);
  }

  /** Shows another style, once it is compiled. @param {StyleData} data @param {number} [side] the detail, which then stays */
  async show(data, side) {
    if (side) this.#isChosen = true;
    this.data = data;
    this.panel = new StylePanel(data, () => this.#edited());
    await this.#choose(side ?? this.side);
    get("facts").textContent = this.#facts(data).join(" ");
  }

  /** @param {StyleData} data */
  #facts({ fixed, focus, plans }) {
    const facts = [this.runner.isSoftware ? "Rendered without a GPU, so this will be slow." : `Rendered on ${this.runner.device}.`];
    if (fixed.length) facts.push(`Fixed in this file: ${fixed.join(", ")}.`);
    const missing = [...(plans[0].plan.server.includes("steady") ? ["Steadiness"] : []), ...(focus ? ["Detail in faces"] : [])];
    if (missing.length) facts.unshift(`Not in this page: ${missing.join(", ")}. Render with vidstyle to use ${missing.length > 1 ? "them" : "it"}.`);
    if (plans[0].plan.server.includes("masks")) facts.push("Masks are only available in vidstyle: here, people fill the picture.");
    return facts;
  }

  /** Shows this detail in the list, and switches to it. @param {number} side */
  #choose(side) {
    this.#detail.value = String(side);
    return this.#use(side);
  }

  /** Switches to the plan for this side once it is compiled. @param {number} side */
  async #use(side) {
    this.#wanted = side;
    this.#wait(Boolean(this.source.picture));
    const wanted = /** @type {StyleData} */ (this.data);
    const found = await loadStyle(this.runner, /** @type {SizedPlan} */ (wanted.plans.find((each) => each.side === side)));
    if (this.data !== wanted || this.#wanted !== side) return;
    if (found !== this.#shown) this.#shown?.style.release();
    this.#shown = found;
    this.#changed();
    found.style.restart();
  }

  /** Shows changed values: in a photograph quickly, then in full detail. */
  #edited() {
    clearTimeout(this.#refining);
    if (!this.source.picture || this.source.video || !this.runner.isSoftware || this.side === SIDES[0]) return this.#changed();
    this.#use(SIDES[0]);
    this.#refining = setTimeout(() => this.#use(this.side), REFINE_MS);
  }

  #changed() {
    if (this.#shown && this.data?.plans.includes(this.#shown) && this.panel)
      this.#shown.style.values = planValues(this.#shown, this.data.controls, this.panel.values);
    this.onchange();
    this.redraw();
  }

  /** Says that a frame is not ready yet. @param {boolean} on */
  #wait(on) {
    get("busy").hidden = !on;
  }

  /** Draws a photograph after the notice of it is on the screen, as drawing may block the page. */
  #drawSoon() {
    this.#wait(Boolean(this.source.picture));
    requestAnimationFrame(() => requestAnimationFrame(() => {
      this.draw();
      this.#wait(this.#shown?.side !== this.side);
    }));
  }

  #opened() {
    clearTimeout(this.#refining);
    this.#wait(true);
    if (this.source.video && !this.#isChosen) this.#choose(this.#filmSide);
    this.#shown?.style.restart();
    document.body.classList.remove("empty");
    get("film").hidden = !this.source.film;
  }

  #framed() {
    const { film } = this.source;
    if (!this.source.video) return this.redraw();
    this.draw();
    requestAnimationFrame(() => this.#wait(false));
    if (film) this.#place.value = String(film.duration ? film.currentTime / film.duration : 0);
  }

  draw() {
    const { picture, size: own, video } = this.source;
    if (!picture || !own[0]) return;
    if (!this.#shown) {
      resize(this.canvas, own);
      this.canvas.getContext("2d")?.drawImage(picture, 0, 0);
      return;
    }
    const size = workingSize(own, this.#shown.side);
    resize(this.canvas, size);
    const began = performance.now();
    if (this.#held) return this.canvas.getContext("2d")?.drawImage(picture, 0, 0, ...size);
    if (!this.runner.draw(this.#shown.style, picture, this.canvas, { time: this.source.time, size })) return;
    this.#divider.paint(picture, own);
    if (video && !video.paused) this.#watchSpeed(performance.now() - began);
    this.#divider.place();
  }

  /** Switches to the next smaller size after many slow frames in a row. @param {number} milliseconds */
  #watchSpeed(milliseconds) {
    this.#slow = milliseconds > MAX_FRAME_MS ? this.#slow + 1 : 0;
    const smaller = Math.max(...SIDES.filter((each) => each < this.side));
    if (this.#slow < MAX_SLOW_FRAMES || smaller < 0) return;
    this.#slow = 0;
    this.#choose(smaller);
    this.say("Detail reduced to keep up with the frame rate.");
  }

  #save() {
    this.draw();
    this.canvas.toBlob((blob) => blob && download(blob, `${this.data?.name}.png`));
  }

  #record() {
    if (this.#recorder) return this.#recorder.stop();
    this.#recorder = record(this.canvas, this.source.video, (clip, extension) => {
      this.#recorder = null;
      press(get("record"), false);
      if (clip.size) download(clip, `${this.data?.name}.${extension}`);
      else this.say("Nothing was recorded.");
    });
    if (!this.#recorder) return this.say("This browser cannot record.");
    press(get("record"), true);
    this.redraw();
  }

  #compare() {
    this.#divider.toggle();
    press(get("compare"), this.#divider.split !== null);
  }

  /** @param {boolean} on whether to show the original */
  #hold(on) {
    this.#held = on;
    press(get("hold"), on);
    this.redraw();
  }

  async #copyLink() {
    const address = addressOf(String(this.data?.name), this.panel?.changes ?? {});
    const note = location.protocol === "file:" ? " It opens this file on this computer; to share it, put the file on a web site." : "";
    await navigator.clipboard.writeText(address).then(() => this.say(`Link copied.${note}`), () => this.say(address, 0));
  }

  #listen() {
    const picker = make("input", { type: "file", accept: "image/*,video/*" });
    picker.id = "file";
    picker.hidden = true;
    document.body.append(picker);
    this.source.listen(picker);
    /** @type {Record<string, () => void>} */
    const clicks = {
      open: () => picker.click(),
      camera: () => this.source.openCamera(),
      again: () => document.body.classList.add("empty"),
      full: () => (document.fullscreenElement ? document.exitFullscreen() : get("viewer").requestFullscreen()),
      play: () => this.source.toggle(),
      save: () => this.#save(),
      record: () => this.#record(),
      compare: () => this.#compare(),
      link: () => this.#copyLink(),
      ask: () => /** @type {HTMLDialogElement} */ (get("keys")).showModal(),
    };
    for (const [id, act] of Object.entries(clicks)) get(id)?.addEventListener("click", act);
    this.#detail.onchange = () => {
      this.#isChosen = true;
      this.#choose(this.side);
    };
    this.#place.oninput = () => {
      const { film } = this.source;
      if (film) film.currentTime = Number(this.#place.value) * film.duration;
    };
    addEventListener("keydown", (event) => this.#press(event));
    addEventListener("keyup", (event) => event.key === SHARED_KEYS.original && this.#hold(false));
    for (const [kind, on] of Object.entries({ pointerdown: true, pointerup: false, pointerleave: false, blur: false }))
      get("hold").addEventListener(kind, () => this.#hold(on));
  }

  /** @param {KeyboardEvent} event */
  #press(event) {
    const target = /** @type {HTMLElement} */ (event.target);
    if (target.matches("input:not([type=range]), select, dialog *") || event.ctrlKey || event.metaKey || event.altKey || !this.source.picture) return;
    if (event.key === SHARED_KEYS.original) return this.#hold(true);
    const id = KEYS[event.key];
    if (!id || !get("stage").checkVisibility()) return;
    if (event.key === " " && (get("film").hidden || target.matches("button"))) return;
    event.preventDefault();
    get(id).click();
  }
}
