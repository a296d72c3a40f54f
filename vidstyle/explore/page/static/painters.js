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
 * @property {(side: number) => Promise<PlanMessage>} plan asks the server for its plan
 * @property {(frame: number, side: number) => string} address of the picture that the server makes of it
 */

/** Restyles with WebGL. */
export class PagePainter {
  /** Plans that are loaded, by their keys. @type {Map<string, Promise<LoadedStyle>>} */
  #loaded = new Map();
  /** @type {Map<string, {side: number, style: LoadedStyle | null, values: number[]}>} */
  #subjects = new Map();

  /** @param {import("./runner.js").Runner} runner @param {SourceFrames} source @param {() => void} onready */
  constructor(runner, source, onready) {
    this.runner = runner;
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
    const { key, values, plan } = await subject.plan(side);
    if (plan && !this.#loaded.has(key)) this.#loaded.set(key, this.runner.load(plan));
    const style = await this.#loaded.get(key);
    if (!style) return;
    Object.assign(entry, { style, values });
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
    return this.runner.draw(entry.style, picture, canvas, { size }) !== null;
  }

  /** Frees what is drawn no more. @param {Set<string>} names of the subjects that still are */
  keep(names) {
    for (const name of this.#subjects.keys()) if (!names.has(name)) this.#subjects.delete(name);
    const used = new Set([...this.#subjects.values()].map((entry) => entry.style));
    for (const style of this.#loaded.values()) style.then((each) => used.has(each) || each.release(), () => {});
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
        this.#ask();
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
