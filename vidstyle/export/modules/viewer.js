// The large picture of a page: one style, its controls, before and after, and saving.

import { announce } from "./announce.js";
import { clock, download, get, make, oncePerFrame, press, title } from "./elements.js";
import { switchOriginal } from "./original_button.js";
import { planValues } from "./plan_values.js";
import { record } from "./recording.js";
import { nameOfResult, PictureSaver } from "./saved_file.js";
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
/** The detail is chosen by the kind of the source and by speed. */
const AUTOMATIC = "auto";
/** Lines of the result per line of a still picture: marks of a style are finer than the picture. */
const MIN_STILL_RATIO = 1.5;
/** Without a GPU, still pictures are drawn in full detail after this time without a change. */
const REFINE_MS = 500;
/** The message about a saved file stays for this time, unless the picture changes. */
const SAVED_SECONDS = 20;
const [DRAWING, DRAFTING, REFINING] = ["Drawing", "Draft", "Full resolution"];
/** The buttons that keys press. @type {Object<string, string>} */
const KEYS = {
  [SHARED_KEYS.compare]: "compare", [SHARED_KEYS.save]: "save", [SHARED_KEYS.full]: "full", [SHARED_KEYS.play]: "play", " ": "play", r: "record", o: "again", [SHARED_KEYS.help]: "ask",
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
    onplay: () => this.#adapt(),
    onframe: () => this.#framed(),
    onjump: () => this.#jumped(),
    report: (text, seconds) => this.say(text, seconds),
  });
  /** The loaded style for the current detail. @type {(SizedPlan & {style: LoadedStyle}) | null} */
  #shown = null;
  /** @type {StyledCanvas} */
  #styled;
  /** @type {MediaRecorder | null} */
  #recorder = null;
  #slow = 0;
  /** The detail of what moves, unless the user chooses it. */
  #movingSide = 0;
  /** The time that the last frame of what moves took; 0: none was slow. */
  #stallMs = 0;
  /** The working size that is shown, or will be once it is compiled. */
  #wanted = 0;
  #refining = 0;
  #saver = new PictureSaver(() => this.#finish(), (text) => this.say(text, SAVED_SECONDS));
  /** Is called when a value of a control has changed. @type {() => void} */
  onchange = () => {};

  /** @param {Runner} runner */
  constructor(runner) {
    this.runner = runner;
    this.#styled = new StyledCanvas(runner, this.source);
    this.#styled.ondrawn = (milliseconds) => this.#drawn(milliseconds);
    this.#styled.onpart = (part) => this.#showPart(part);
    this.#movingSide = this.#fastSide;
    this.source.autoplay = !runner.isSoftware; // without a GPU, decoding would slow down the first frame
    this.#listen();
    switchTheme(get("theme"));
  }

  /** Shows a message. @param {string} text @param {number} [seconds] 0: until the next message */
  say(text, seconds = 6) {
    announce(get("message"), text, { seconds });
  }

  /** Whether a photograph or a paused film is shown. */
  get #isStill() {
    const { picture, video, film } = this.source;
    return Boolean(picture) && (!video || Boolean(film?.paused));
  }

  /** The detail at which what moves begins. */
  get #fastSide() {
    return SIDES[this.runner.isSoftware ? 0 : 1];
  }

  /** The detail of still pictures. Faces lose their features in a smaller picture. */
  get #stillSide() {
    return SIDES.find((side) => side >= MIN_STILL_RATIO * Math.min(...this.source.size)) ?? SIDES[SIDES.length - 1];
  }

  /** The working size: the length of the shorter side. */
  get side() {
    const { value } = this.#detail;
    if (value !== AUTOMATIC) return Number(value);
    return this.#isStill ? this.#stillSide : this.#movingSide;
  }

  /** Shows another style, once it is compiled. @param {StyleData} data @param {number} [side] the detail, which then stays */
  async show(data, side) {
    if (side) this.#detail.value = String(side);
    this.data = data;
    get("divider-look").textContent = title(data.name);
    this.panel = new StylePanel(data, () => this.#edited());
    await this.#adapt();
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

  /** Switches to the detail for a still picture or for a playing film. */
  #adapt() {
    return this.data && this.#use(this.#isRefined ? SIDES[0] : this.side);
  }

  /** Whether the picture is first drawn in little detail: without a GPU, if it stands still. */
  get #isRefined() {
    return this.#isStill && this.runner.isSoftware && this.side > SIDES[0] && !this.#styled.prepared;
  }

  /** Switches to the plan for this side once it is compiled. @param {number} side */
  async #use(side) {
    clearTimeout(this.#refining);
    this.#wanted = side;
    this.#wait(this.#reason);
    this.#describe();
    const wanted = /** @type {StyleData} */ (this.data);
    const found = await loadStyle(this.runner, /** @type {SizedPlan} */ (wanted.plans.find((each) => each.side === side)));
    if (this.data !== wanted || this.#wanted !== side) return;
    if (found !== this.#shown) this.#shown?.style.release();
    this.#shown = this.#styled.shown = found;
    this.#changed();
    found.style.restart();
  }

  /** Shows changed values: still pictures quickly first, then in full detail. */
  #edited() {
    this.say("");
    this.#styled.prepared = null;
    if (this.runner.isSoftware && this.#isStill) this.#styled.expire();
    if (this.#isRefined) this.#use(SIDES[0]);
    else this.#changed();
  }

  #changed() {
    if (this.#shown && this.data?.plans.includes(this.#shown) && this.panel)
      this.#shown.style.values = planValues(this.#shown, this.data.controls, this.panel.values);
    this.onchange();
    if (this.runner.isSoftware && this.#isStill) this.#wait(this.#reason);
    this.redraw();
  }

  /** Why the picture is not ready yet. */
  get #reason() {
    if (!this.source.picture) return "";
    if (!this.#isRefined) return DRAWING;
    return this.#wanted === this.side && this.#styled.isDrawn ? REFINING : DRAFTING;
  }

  /** Shows why the picture is not ready yet. @param {string} text */
  #wait(text) {
    get("busy").hidden = !text || Boolean(this.#styled.prepared);
    get("busy-reason").textContent = text;
    get("busy-part").textContent = "…";
    this.#describe();
  }

  /** @param {number} part of the picture that is drawn */
  #showPart(part) {
    get("busy-part").textContent = ` ${Math.round(100 * part)} %`;
    // A draft takes as much of the time as it has of the pixels.
    if (this.#shown) this.#saver.progress(part * (this.#shown.side / this.side) ** 2);
  }

  /** Shows the source in the style until it is drawn, if all values are the style's own. @param {CanvasImageSource} picture */
  prepare(picture) {
    if (Object.keys(this.panel?.changes ?? {}).length) return;
    this.#styled.prepared = picture;
    this.#adapt();
    this.#styled.compose();
  }

  #opened() {
    clearTimeout(this.#refining);
    this.say(""); // removes the message about an earlier file
    this.#movingSide = this.#fastSide;
    this.#wait(DRAWING);
    const hadFocus = get("welcome").contains(document.activeElement);
    if (document.body.matches(".example")) this.compare(null);
    document.body.classList.remove("empty", "example");
    get("back").hidden = true;
    get("film").hidden = !this.source.film;
    get("record").hidden = !this.source.video;
    if (hadFocus) get("again").focus();
    this.#styled.open();
    this.#adapt();
    this.#shown?.style.restart();
  }

  /** Another part of a film is about to be shown. */
  #jumped() {
    this.#shown?.style.restart();
    if (this.#isRefined) this.#adapt();
  }

  #framed() {
    const { film, video } = this.source;
    if (!video) return this.redraw();
    if (this.#styled.isHeld) this.#styled.compose();
    else if (!this.runner.isSoftware || this.#shown?.side === this.#wanted) this.#styled.draw();
    if (film) this.#showTime(film);
  }

  /** @param {HTMLVideoElement} film */
  #showTime({ currentTime, duration }) {
    const isEndless = !Number.isFinite(duration);
    this.#place.value = String(isEndless ? 0 : currentTime / duration);
    get("time").textContent = isEndless ? clock(currentTime) : `${clock(currentTime)} / ${clock(duration)}`;
    this.#place.setAttribute("aria-valuetext", clock(currentTime));
  }

  /** @param {number} milliseconds that the last frame took */
  #drawn(milliseconds) {
    if (!this.#isStill) {
      this.#wait("");
      this.#watchSpeed(milliseconds);
    } else if (this.#styled.isOutdated) {
      return;
    } else if (this.#shown?.side !== this.side) {
      this.#wait(REFINING);
      this.#refining = setTimeout(() => this.#use(this.side), REFINE_MS);
    } else this.#wait("");
  }

  /** Says under the choice of the detail what it is now, and why. */
  #describe() {
    const { film, picture } = this.source;
    const isAutomatic = this.#detail.value === AUTOMATIC && picture;
    const isDraft = this.#styled.drawnSide && this.#styled.drawnSide < this.side;
    const busy = isDraft ? "A coarser draft is shown meanwhile" : "The picture is being drawn";
    const still = get("busy").hidden ? "The picture has its full resolution" : busy;
    const reason = this.#isStill ? still : `${this.side} lines while it moves${film ? "; all lines when paused" : ""}`;
    const speed = this.#isStill || !this.#stallMs ? "" : ` A frame takes ${(this.#stallMs / 1000).toFixed(1)} s${this.runner.isSoftware ? " without a GPU" : ""}.`;
    get("quality").textContent = (isAutomatic ? `${reason}.` : "") + speed;
  }

  /** Switches to the next smaller size after many slow frames in a row, unless the user has chosen one. @param {number} milliseconds */
  #watchSpeed(milliseconds) {
    this.#stallMs = milliseconds > MAX_STALL_MS ? milliseconds : 0;
    this.#slow = milliseconds > MAX_FRAME_MS ? this.#slow + 1 : 0;
    const smaller = Math.max(...SIDES.filter((each) => each < this.#movingSide));
    const isSlow = this.#slow >= MAX_SLOW_FRAMES || milliseconds >= MAX_STALL_MS;
    if (isSlow && smaller > 0 && this.#detail.value === AUTOMATIC) {
      this.#slow = 0;
      this.#movingSide = smaller;
      this.#adapt();
      this.say("Lower resolution while it moves, to keep up with the film.");
    } else this.#describe();
  }

  /** Draws a still picture in full resolution, unless that is done or under way; of a film, the present frame. Returns it. */
  async #finish() {
    for (;;) {
      await new Promise(requestAnimationFrame); // a change is drawn from then on
      if (this.#shown && (!this.#isStill || (this.#shown?.side === this.side && this.#styled.isCurrent))) return this.#styled.finish();
      // First the draft, if there is one: it shows the choice.
      const isDrafted = this.#wanted >= this.side || (this.#shown?.side === this.#wanted && this.#styled.isCurrent);
      if (this.#shown && !isDrafted) {
        await this.#use(this.#wanted);
        await new Promise(requestAnimationFrame);
        await this.#styled.finish();
      } else if (!this.#shown || this.#wanted !== this.side) await this.#use(this.side);
      else await this.#styled.finish();
    }
  }

  #record() {
    if (this.#recorder) return this.#recorder.stop();
    const { film } = this.source;
    const isPaused = Boolean(film?.paused);
    this.#recorder = record(this.#styled, this.source.video, {
      ontime: (seconds) => (get("record-label").textContent = `Stop, ${clock(seconds)}`),
      onend: (clip, extension) => this.#recorded(clip, extension, isPaused ? film : null),
    });
    if (!this.#recorder) return this.say("This browser cannot record.");
    press(get("record"), true);
    if (isPaused) film?.play();
    const speed = film && this.runner.isSoftware ? " Without a GPU it shows only few frames: “vidstyle render” draws them all." : "";
    const compared = this.#styled.divider.split === null ? "" : " The comparison is recorded, too.";
    this.say(`Recording${isPaused ? "; the film plays meanwhile" : ""}.${compared}${speed}`, 0);
  }

  /** Saves a clip. @param {Blob} clip @param {string} extension @param {HTMLVideoElement | null} paused the film to pause again */
  #recorded(clip, extension, paused) {
    this.#recorder = null;
    paused?.pause();
    press(get("record"), false);
    get("record-label").textContent = "Record clip";
    const name = nameOfResult(this.source.name, String(this.data?.name), extension);
    if (clip.size) download(clip, name);
    this.say(clip.size ? `${name} is in your downloads.` : "The browser has recorded nothing.", SAVED_SECONDS);
  }

  /** Offers to open another file, or returns to the picture. @param {boolean} on */
  #invite(on) {
    document.body.classList.toggle("empty", on);
    get("back").hidden = !on;
    get(on ? "open" : "again").focus();
  }

  /** Divides the picture: on the left of this fraction of its width, the original; null: nowhere. @param {number | null} split */
  compare(split) {
    this.#styled.divider.move(split);
    press(get("compare"), split !== null);
  }

  #toggleCompare() {
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
      open: () => {
        picker.value = ""; // the same file is a choice, too
        picker.click();
      },
      camera: () => this.source.openCamera(),
      again: () => this.#invite(true),
      back: () => this.#invite(false),
      full: () => (document.fullscreenElement ? document.exitFullscreen() : get("viewer").requestFullscreen()),
      play: () => this.source.toggle(),
      save: () => this.#saver.save(this.source, String(this.data?.name)),
      record: () => this.#record(),
      compare: () => this.#toggleCompare(),
      link: () => this.#copyLink(),
      ask: () => /** @type {HTMLDialogElement} */ (get("keys")).showModal(),
    };
    for (const [id, act] of Object.entries(clicks)) get(id)?.addEventListener("click", act);
    this.#detail.onchange = () => this.#adapt();
    this.#place.oninput = () => {
      const { film } = this.source;
      if (film) film.currentTime = Number(this.#place.value) * film.duration;
    };
    addEventListener("keydown", (event) => this.#press(event));
    addEventListener("keyup", (event) => event.key === SHARED_KEYS.original && this.#hold(false));
    switchOriginal(get("hold"), () => this.#styled.isHeld, (on) => this.#hold(on));
  }

  /** @param {KeyboardEvent} event */
  #press(event) {
    const target = /** @type {HTMLElement} */ (event.target);
    // Only fields for text take the key for help.
    const keeps = event.key === SHARED_KEYS.help ? "input:is([type=text], [type=search]), textarea" : "input:not([type=range]), select";
    if (target.matches(`${keeps}, dialog *`) || event.ctrlKey || event.metaKey || event.altKey || !this.source.picture) return;
    if (event.key === SHARED_KEYS.original) return this.#hold(true);
    if (event.key === "Escape" && !get("back").hidden) return this.#invite(false);
    const id = event.key === "o" && document.body.matches(".empty") ? "open" : KEYS[event.key];
    if (!id || get(id).hidden || !get("stage").checkVisibility()) return;
    if (event.key === " " && (get("film").hidden || target.matches("button"))) return;
    event.preventDefault();
    get(id).click();
  }
}
