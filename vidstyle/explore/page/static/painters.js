/**
 * Two ways to restyle the clip: in the page on the user's graphics card, or by the server.
 *
 * A painter draws a style that it is told by a key of its own choice (a tile, or a point of a plane).
 *
 * @module
 */

import { fetched } from "./source_frames.js";

/** @typedef {import("./explore_types.js").PlanMessage} PlanMessage */
/** @typedef {import("./source_frames.js").SourceFrames} SourceFrames */
/** @typedef {import("./runner.js").LoadedStyle} LoadedStyle */

/**
 * A style to draw.
 * @typedef {object} Subject
 * @property {string} name tells it from others
 * @property {(side: number, whole: boolean) => Promise<PlanMessage>} plan asks the server for its plan; `whole`:
 *   also if it was sent before
 * @property {(frame: number, side: number) => string} address of the picture that the server makes of it
 */

/** How many plans stay loaded: those that are shown, and those to which one is likely to come back. */
const KEPT = 40;

/** The plans that are loaded, for all painters: the server sends each of them once. */
export class LoadedPlans {
  /** By their keys, the one used last at the end. @type {Map<string, Promise<LoadedStyle>>} */
  #styles = new Map();

  /** @param {import("./runner.js").Runner} runner */
  constructor(runner) {
    this.runner = runner;
  }

  /**
   * The style of a plan, and the values of the subject.
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
      if (this.#styles.size <= KEPT) break;
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

  /** How many frames of a subject can be shown. */
  count() {
    return this.source.ready;
  }

  /**
   * Gets a subject ready.
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
   * Draws a frame; whether it did.
   * @param {Subject} subject @param {number} place of the frame @param {HTMLCanvasElement} canvas
   */
  draw(subject, place, canvas) {
    const entry = this.#subjects.get(subject.name);
    const picture = this.source.pictures[place];
    if (!entry?.style || !picture) return false;
    const size = entry.style.plan.size;
    if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
    // Styles that differ in values alone share programs and textures.
    entry.style.values = entry.values;
    return this.plans.runner.draw(entry.style, picture, canvas, { size }) !== null;
  }

  /** Frees what is drawn no more. @param {Set<string>} names of the subjects that still are */
  keep(names) {
    const gone = [...this.#subjects].filter(([name]) => !names.has(name));
    for (const [name] of gone) this.#subjects.delete(name);
    const used = new Set([...this.#subjects.values()].map((entry) => entry.style));
    for (const [, { style }] of gone) if (!used.has(style)) style?.release();
  }
}

const UNDER_WAY = 4;
/** The server makes every third frame: at least as many as move, and no more than it can. */
const EVERY = 3;

/** Shows what the server has restyled. */
export class ServerPainter {
  /** @type {Map<string, {subject: Subject, side: number, pictures: ImageBitmap[], asked: number, stop: AbortController, begin: () => void}>} */
  #subjects = new Map();
  #underWay = 0;

  /** @param {SourceFrames} source @param {() => void} onready */
  constructor(source, onready) {
    this.source = source;
    this.onready = onready;
  }

  /** How many frames of a subject can be shown; it moves once all are there. @param {Subject} subject */
  count(subject) {
    const frames = this.source.clip?.frames.length ?? 0;
    const entry = this.#subjects.get(subject.name);
    return entry && entry.pictures.length === Math.ceil(frames / EVERY) ? frames : Math.min(1, entry?.pictures.length ?? 0);
  }

  /** As that of `PagePainter`; is done when the first picture is there. @param {Subject} subject @param {number} side */
  prepare(subject, side) {
    const known = this.#subjects.get(subject.name);
    if (known?.side === side) return Promise.resolve();
    known?.stop.abort();
    const pictures = known?.pictures.slice(0, 1) ?? [];
    return /** @type {Promise<void>} */ (
      new Promise((begin) => {
        this.#subjects.set(subject.name, { subject, side, pictures, asked: 0, stop: new AbortController(), begin });
        // Later, when all that is shown is known: the first would ask for its moving pictures before the others' first.
        queueMicrotask(() => this.#ask());
      })
    );
  }

  /** @param {Subject} subject @param {number} place @param {HTMLCanvasElement} canvas */
  draw(subject, place, canvas) {
    const picture = this.#subjects.get(subject.name)?.pictures[Math.floor(place / EVERY)];
    if (!picture) return false;
    if (canvas.width !== picture.width || canvas.height !== picture.height) [canvas.width, canvas.height] = [picture.width, picture.height];
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

  /** Asks for the pictures that are missing: first one of each subject, then the next of each. */
  async #ask() {
    const frames = this.source.clip?.frames.filter((_, place) => place % EVERY === 0) ?? [];
    const entries = [...this.#subjects.values()].filter((each) => each.asked < frames.length);
    if (this.#underWay >= UNDER_WAY || !entries.length) return;
    const entry = entries.reduce((best, each) => (each.asked < best.asked ? each : best));
    const place = entry.asked++;
    this.#underWay++;
    this.#ask();
    const picture = await fetched(entry.subject.address(frames[place], entry.side), entry.stop.signal).catch(() => null);
    this.#underWay--;
    if (picture && !entry.stop.signal.aborted) {
      entry.pictures[place] = picture;
      this.onready();
    }
    entry.begin();
    this.#ask();
  }
}
