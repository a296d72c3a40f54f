/**
 * Two ways to restyle the clip: in the browser on the user's GPU, or on the server.
 *
 * A painter draws subjects: tiles, or points of the tuning pad.
 *
 * @module
 */

import { resize } from "./elements.js";
import { fetchPicture } from "./source_frames.js";

/** @typedef {import("./explore_types.js").PlanMessage} PlanMessage */
/** @typedef {import("./source_frames.js").SourceFrames} SourceFrames */
/** @typedef {import("./runner.js").LoadedStyle} LoadedStyle */

/**
 * A style to draw.
 * @typedef {object} Subject
 * @property {string} name unique among subjects
 * @property {(side: number, whole: boolean) => Promise<PlanMessage>} plan requests its plan from the server;
 *   `whole`: even if it was sent before
 * @property {(frame: number, side: number) => string} address the URL of the picture that the server renders
 */

/** Number of plans that stay loaded, so that recent tiles can be shown again quickly. */
const MAX_LOADED_PLANS = 40;

/** Cache of loaded plans for all painters; the server sends each plan once. */
export class LoadedPlans {
  /** Styles by key, least recently used first. @type {Map<string, Promise<LoadedStyle>>} */
  #styles = new Map();

  /** @param {import("./runner.js").Runner} runner */
  constructor(runner) {
    this.runner = runner;
  }

  /**
   * Returns the loaded style and the values of a subject.
   * @param {Subject} subject @param {number} side
   */
  async get(subject, side) {
    let { key, values, plan } = await subject.plan(side, false);
    if (!plan && !this.#styles.has(key)) ({ key, values, plan } = await subject.plan(side, true));
    const style = this.#styles.get(key) ?? (plan && this.runner.load(plan));
    if (!style) throw new Error("the server did not send the plan");
    this.#styles.delete(key);
    this.#styles.set(key, style);
    for (const [oldest, old] of this.#styles) {
      if (this.#styles.size <= MAX_LOADED_PLANS) break;
      this.#styles.delete(oldest);
      old.then((each) => this.runner.unload(each), () => {});
    }
    return { style: await style, values };
  }
}

/** Restyles with WebGL. */
export class PagePainter {
  /** @type {Map<string, {side: number, style: LoadedStyle | null, values: number[]}>} */
  #subjects = new Map();

  /** @param {LoadedPlans} plans @param {SourceFrames} source @param {() => void} onready */
  constructor(plans, source, onready) {
    this.plans = plans;
    this.source = source;
    this.onready = onready;
  }

  /** Returns the number of frames that can be shown. */
  count() {
    return this.source.ready;
  }

  /** Does nothing: the source has all frames. */
  resume() {}

  /**
   * Prepares a subject for drawing.
   * @param {Subject} subject
   * @param {number} side the shorter side at which it is drawn
   */
  async prepare(subject, side) {
    const known = this.#subjects.get(subject.name);
    if (known?.side === side) return;
    const entry = { side, style: known?.style ?? null, values: known?.values ?? [] };
    this.#subjects.set(subject.name, entry);
    Object.assign(entry, await this.plans.get(subject, side));
    this.onready();
  }

  /**
   * Draws a frame; returns whether it could.
   * @param {Subject} subject @param {number} place of the frame @param {HTMLCanvasElement} canvas
   */
  draw(subject, place, canvas) {
    const entry = this.#subjects.get(subject.name);
    const picture = this.source.pictures[place];
    if (!entry?.style || !picture) return false;
    const size = entry.style.plan.size;
    resize(canvas, size);
    // Styles that differ only in values share programs and textures.
    entry.style.values = entry.values;
    return this.plans.runner.draw(entry.style, picture, canvas, { size }) !== null;
  }

  /** Releases all subjects but these. @param {Set<string>} names of the subjects to keep */
  keep(names) {
    const gone = [...this.#subjects].filter(([name]) => !names.has(name));
    for (const [name] of gone) this.#subjects.delete(name);
    const used = new Set([...this.#subjects.values()].map((entry) => entry.style));
    for (const [, { style }] of gone) if (!used.has(style)) style?.release();
  }
}

const MAX_PENDING_REQUESTS = 4;
/** The server renders every third frame, to limit its load. */
const FRAME_STEP = 3;

/** Shows pictures that the server restyles. */
export class ServerPainter {
  /** @type {Map<string, {subject: Subject, side: number, pictures: ImageBitmap[], asked: number, stop: AbortController, begin: () => void}>} */
  #subjects = new Map();
  #pending = 0;

  /** @param {SourceFrames} source @param {() => void} onready */
  constructor(source, onready) {
    this.source = source;
    this.onready = onready;
  }

  /** Requests the pictures that playing needs. */
  resume() {
    for (let each = 0; each < MAX_PENDING_REQUESTS; each++) this.#ask();
  }

  /** Returns the number of frames that can be shown: one until all have arrived. @param {Subject} subject */
  count(subject) {
    const frames = this.source.clip?.frames.length ?? 0;
    const entry = this.#subjects.get(subject.name);
    return entry && entry.pictures.length === Math.ceil(frames / FRAME_STEP) ? frames : Math.min(1, entry?.pictures.length ?? 0);
  }

  /** Like the method of `PagePainter`; resolves when the first picture has arrived. @param {Subject} subject @param {number} side */
  prepare(subject, side) {
    const known = this.#subjects.get(subject.name);
    if (known?.side === side) return Promise.resolve();
    known?.stop.abort();
    const pictures = known?.pictures.slice(0, 1) ?? [];
    return /** @type {Promise<void>} */ (
      new Promise((begin) => {
        this.#subjects.set(subject.name, { subject, side, pictures, asked: 0, stop: new AbortController(), begin });
        // Deferred until all subjects are known; else the first one would request all its pictures before the others.
        queueMicrotask(() => this.#ask());
      })
    );
  }

  /** @param {Subject} subject @param {number} place @param {HTMLCanvasElement} canvas */
  draw(subject, place, canvas) {
    const picture = this.#subjects.get(subject.name)?.pictures[Math.floor(place / FRAME_STEP)];
    if (!picture) return false;
    resize(canvas, [picture.width, picture.height]);
    canvas.getContext("2d")?.drawImage(picture, 0, 0);
    return true;
  }

  /** @param {Set<string>} names */
  keep(names) {
    for (const [name, entry] of this.#subjects) {
      if (names.has(name)) continue;
      entry.stop.abort();
      this.#subjects.delete(name);
    }
  }

  /** Requests missing pictures, one at a time from each subject in turn. */
  async #ask() {
    const frames = this.source.clip?.frames.filter((_, place) => place % FRAME_STEP === 0) ?? [];
    const wanted = this.source.playing ? frames.length : 1;
    const entries = [...this.#subjects.values()].filter((each) => each.asked < wanted);
    if (this.#pending >= MAX_PENDING_REQUESTS || !entries.length) return;
    const entry = entries.reduce((best, each) => (each.asked < best.asked ? each : best));
    const place = entry.asked++;
    this.#pending++;
    this.#ask();
    const picture = await fetchPicture(entry.subject.address(frames[place], entry.side), entry.stop.signal).catch(() => null);
    this.#pending--;
    if (picture && !entry.stop.signal.aborted) {
      entry.pictures[place] = picture;
      this.onready();
    }
    entry.begin();
    this.#ask();
  }
}
