// The large picture of a page: one style, its controls, before and after, and saving.

import { announce } from "./announce.js";
import { download, get, make, oncePerFrame, press } from "./elements.js";
import { planValues } from "./plan_values.js";
import { record } from "./recording.js";
import { SHARED_KEYS } from "./shared_keys.js";
import { addressOf } from "./shared_link.js";
import { Source } from "./source.js";
import { StylePanel } from "./style_panel.js";
import { StyledCanvas } from "./styled_canvas.js";
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
/** After one frame that takes as long, it is reduced at once. */
const MAX_STALL_MS = 700;
const SIDES = [360, 720, 1080];
/** Photographs are shown in full detail: faces lose their features in a smaller picture. */
const PHOTOGRAPH_SIDE = SIDES[2];
/** Without a GPU, a photograph is drawn in full detail once it has not changed for this time. */
const REFINE_MS = 500;
const [DRAWING, REFINING] = ["Drawing…", "Draft; drawing in full detail…"];
/** The buttons that keys press. @type {Object<string, string>} */
const KEYS = {
  [SHARED_KEYS.compare]: "compare", [SHARED_KEYS.save]: "save", [SHARED_KEYS.full]: "full", [SHARED_KEYS.play]: "play", " ": "play", r: "record", [SHARED_KEYS.help]: "ask",
};

/** Returns a style that is loaded for one working size. @param {Runner} runner @param {SizedPlan} sized @returns {Promise<SizedPlan & {style: LoadedStyle}>} */
export async function loadStyle(runner, sized) {
  sized.style ??= await runner.load(sized.plan);
  return /** @type {SizedPlan & {style: LoadedStyle}} */ (sized);
}

/** Shows a picture in a style, in the elements of `stage.html`. */
export class Viewer {
  /** @type {StyleData | null} */
  data = null;
  /** @type {StylePanel | null} */
  panel = null;
  #place = /** @type {HTMLInputElement} */ (get("place"));
  #detail = /** @type {HTMLSelectElement} */ (get("side"));
  redraw = oncePerFrame(() => this.#styled.draw());
  source = new Source({
    onopen: () => this.#opened(),
    onphotograph: () => this.#isChosen || this.choose(PHOTOGRAPH_SIDE),
    onframe: () => this.#framed(),
    onjump: () => this.#shown?.style.restart(),
    report: (text, seconds) => this.say(text, seconds),
  });
  /** The loaded style for the current detail. @type {(SizedPlan & {style: LoadedStyle}) | null} */
  #shown = null;
  /** @type {StyledCanvas} */
  #styled;
  /** @type {MediaRecorder | null} */
  #recorder = null;
  #slow = 0;
  /** Whether the user has chosen the detail. */
  #isChosen = false;
  /** The working size that is shown, or will be once it is compiled. */
  #wanted = 0;
  #refining = 0;
  /** Is called when a value of a control has changed. @type {() => void} */
  onchange = () => {};

  /** @param {Runner} runner */
  constructor(runner) {
    this.runner = runner;
    this.#styled = new StyledCanvas(runner, this.source);
    this.#styled.ondrawn = (milliseconds) => this.#drawn(milliseconds);
    this.#detail.value = String(this.#filmSide);
    this.source.autoplay = !runner.isSoftware; // without a GPU, decoding would slow down the first frame
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
    await this.choose(side ?? this.side);
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
  choose(side) {
    this.#detail.value = String(side);
    return this.#use(this.#isRefined ? SIDES[0] : side);
  }

  /** Whether the picture is first drawn in little detail: a photograph without a GPU. */
  get #isRefined() {
    return Boolean(this.source.picture) && !this.source.video && this.runner.isSoftware && this.side > SIDES[0];
  }

  /** Switches to the plan for this side once it is compiled. @param {number} side */
  async #use(side) {
    clearTimeout(this.#refining);
    this.#wanted = side;
    this.#wait(this.#reason);
    const wanted = /** @type {StyleData} */ (this.data);
    const found = await loadStyle(this.runner, /** @type {SizedPlan} */ (wanted.plans.find((each) => each.side === side)));
    if (this.data !== wanted || this.#wanted !== side) return;
    if (found !== this.#shown) this.#shown?.style.release();
    this.#shown = this.#styled.shown = found;
    this.#changed();
    found.style.restart();
  }

  /** Shows changed values: in a photograph quickly, then in full detail. */
  #edited() {
    if (this.#isRefined) this.#use(SIDES[0]);
    else this.#changed();
  }

  #changed() {
    if (this.#shown && this.data?.plans.includes(this.#shown) && this.panel)
      this.#shown.style.values = planValues(this.#shown, this.data.controls, this.panel.values);
    this.onchange();
    if (this.runner.isSoftware && !this.source.video) this.#wait(this.#reason);
    this.redraw();
  }

  /** Why the picture is not ready yet. */
  get #reason() {
    if (!this.source.picture) return "";
    return this.#isRefined && this.#wanted === this.side ? REFINING : DRAWING;
  }

  /** Shows why the picture is not ready yet. @param {string} text */
  #wait(text) {
    get("busy").hidden = !text;
    get("busy").textContent = text;
  }

  #opened() {
    clearTimeout(this.#refining);
    this.#wait(DRAWING);
    document.body.classList.remove("empty", "example");
    get("film").hidden = !this.source.film;
    this.#styled.open();
    if (this.source.video && !this.#isChosen) this.choose(this.#filmSide);
    this.#shown?.style.restart();
  }

  #framed() {
    const { film, video } = this.source;
    if (!video) return this.redraw();
    if (this.#styled.isHeld) this.#styled.compose();
    else if (!this.runner.isSoftware || this.#shown?.side === this.#wanted) this.#styled.draw();
    if (film) this.#place.value = String(film.duration ? film.currentTime / film.duration : 0);
  }

  /** @param {number} milliseconds that the last frame took */
  #drawn(milliseconds) {
    const { video } = this.source;
    if (video) {
      this.#wait(milliseconds > MAX_STALL_MS && this.side === SIDES[0] ? `Without a GPU: a frame takes ${(milliseconds / 1000).toFixed(1)} s` : "");
      if (!video.paused) this.#watchSpeed(milliseconds);
    } else if (this.#styled.isOutdated) {
      return;
    } else if (this.#shown?.side !== this.side) {
      this.#wait(REFINING);
      this.#refining = setTimeout(() => this.#use(this.side), REFINE_MS);
    } else this.#wait("");
  }

  /** Switches to the next smaller size after many slow frames in a row. @param {number} milliseconds */
  #watchSpeed(milliseconds) {
    this.#slow = milliseconds > MAX_FRAME_MS ? this.#slow + 1 : 0;
    const smaller = Math.max(...SIDES.filter((each) => each < this.side));
    if ((this.#slow < MAX_SLOW_FRAMES && milliseconds < MAX_STALL_MS) || smaller < 0) return;
    this.#slow = 0;
    this.choose(smaller);
    this.say("Detail reduced to keep up with the frame rate.");
  }

  async #save() {
    if (this.#shown?.side !== this.side) await this.#use(this.side);
    await this.#styled.draw();
    this.#styled.canvas.toBlob((blob) => blob && download(blob, `${this.data?.name}.png`));
  }

  #record() {
    if (this.#recorder) return this.#recorder.stop();
    this.#recorder = record(this.#styled.canvas, this.source.video, (clip, extension) => {
      this.#recorder = null;
      this.#markRecording(false);
      if (clip.size) download(clip, `${this.data?.name}.${extension}`);
      else this.say("Nothing was recorded.");
    });
    if (!this.#recorder) return this.say("This browser cannot record.");
    this.#markRecording(true);
    if (this.source.video?.paused) this.source.video.play();
    this.redraw();
  }

  /** @param {boolean} on */
  #markRecording(on) {
    press(get("record"), on);
    get("record-label").textContent = on ? "Stop recording" : "Record clip";
  }

  #compare() {
    this.#styled.divider.toggle();
    press(get("compare"), this.#styled.divider.split !== null);
  }

  /** @param {boolean} on whether to show the original */
  #hold(on) {
    this.#styled.isHeld = on;
    press(get("hold"), on);
    this.#styled.compose();
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
      this.choose(this.side);
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
