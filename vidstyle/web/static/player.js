// Playback of a film that the server decodes: single frames, or a loop.

/**
 * @typedef {object} Clip
 * @property {string} name
 * @property {[number, number]} size width and height
 * @property {number} count of frames; 1 for a photograph
 * @property {number} fps
 * @property {number} start the frame to show first
 * @property {boolean} live whether it is a camera; then the newest frame is shown
 */

/** @typedef {(message: string, fields: object) => Promise<any>} Ask */

/** The key under which the position in a film is kept while the page is loaded again. @param {Clip} clip */
const positionKey = ({ name, count }) => `position ${count} ${name}`;

/** Requests frames and holds the position in the film. */
export class Player {
  /** @type {Clip} */
  clip = { name: "", size: [0, 0], count: 0, fps: 25, start: 0, live: false };
  /** The frame that was shown or requested last. */
  number = 0;
  playing = false;
  /** The first and last frame of the loop; null: the whole film. @type {[number, number] | null} */
  range = null;
  #asked = false;
  /** @type {number | null} */
  #next = null;

  /**
   * @param {Ask} ask
   * @param {() => void} onchange is called when any property has changed
   */
  constructor(ask, onchange) {
    this.ask = ask;
    this.onchange = onchange;
  }

  /** Whether the clip can be played. */
  get isFilm() {
    return this.clip.count > 1 && !this.clip.live;
  }

  /** Returns the time of a frame in seconds. @param {number} number */
  time(number) {
    return number / (this.clip.fps || 1);
  }

  /** Opens another clip. @param {Clip} clip */
  open(clip) {
    this.clip = clip;
    this.number = Math.min(Number(sessionStorage.getItem(positionKey(clip)) ?? clip.start), Math.max(0, clip.count - 1));
    this.range = null;
    this.playing = clip.live;
    this.onchange();
  }

  /** Pauses and shows a frame; while a request is pending, only the newest is kept. @param {number} number */
  async show(number) {
    if (this.clip.live) return;
    if (this.playing) await this.pause();
    this.number = Math.max(0, Math.min(this.clip.count - 1, Math.round(number)));
    this.#remember();
    this.onchange();
    this.#next = this.number;
    if (this.#asked) return;
    this.#asked = true;
    while (this.#next !== null) {
      const wanted = this.#next;
      this.#next = null;
      await this.ask("frame", { number: wanted }).catch(() => {});
    }
    this.#asked = false;
  }

  /** Moves by a number of frames; wraps around at the ends. @param {number} frames */
  step(frames) {
    const { count } = this.clip;
    return this.show((this.number + frames + count) % count);
  }

  async play() {
    if (!this.isFilm || this.playing) return;
    this.playing = true;
    this.onchange();
    const [first, last] = this.range ?? [0, this.clip.count - 1];
    const at = this.number < first || this.number >= last ? first : this.number;
    await this.ask("play", { at, first, last, fps: this.clip.fps });
  }

  /** Pauses; has no effect on a camera. */
  async pause() {
    if (this.clip.live) return;
    this.playing = false;
    this.onchange();
    await this.ask("pause", {});
  }

  toggle() {
    return this.playing ? this.pause() : this.play();
  }

  /** Sets the loop. @param {[number, number] | null} range */
  async setRange(range) {
    const playing = this.playing;
    this.range = range;
    if (playing) await this.pause();
    this.onchange();
    if (playing) await this.play();
  }

  /** Updates the position when a frame arrives during playback. @param {number} number */
  shown(number) {
    if (!this.playing) return;
    this.number = number;
    this.#remember();
    this.onchange();
  }

  /** Keeps the position in case the page is loaded again. */
  #remember() {
    sessionStorage.setItem(positionKey(this.clip), String(this.number));
  }
}
