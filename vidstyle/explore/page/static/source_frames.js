/**
 * The few seconds of the clip that move in the tiles, held by the page.
 *
 * @module
 */

/** @typedef {import("./explore_types.js").Clip} Clip */

/** Fetches the frames of a clip and says which one is due. */
export class SourceFrames {
  /** @type {Clip | null} */
  clip = null;
  /** The frames by their place among those that move. @type {(ImageBitmap | undefined)[]} */
  pictures = [];
  playing = true;
  #began = 0;
  #place = 0;
  #asked = 0;

  /** @param {() => void} onchange is called when a frame has come */
  constructor(onchange) {
    this.onchange = onchange;
  }

  /**
   * Takes another clip, or another part of it.
   * @param {Clip} clip
   * @param {number | null} side the shorter side; null where the frames themselves are not needed
   */
  async open(clip, side) {
    const asked = ++this.#asked;
    for (const picture of this.pictures) picture?.close();
    this.clip = clip;
    this.pictures = [];
    this.#began = performance.now();
    for (const [place, frame] of side === null ? [] : clip.frames.entries()) {
      const picture = await fetched(`frame.jpg?frame=${frame}&side=${side}`).catch(() => undefined);
      if (asked !== this.#asked) return picture?.close();
      this.pictures[place] = picture;
      this.onchange();
    }
  }

  /** How many frames are there, without a gap from the first on. */
  get ready() {
    const gap = this.pictures.findIndex((each) => !each);
    return gap < 0 ? this.pictures.length : gap;
  }

  /** The place of the frame that is due. @param {number} count how many can be shown */
  due(count) {
    if (this.playing && this.clip && count > 1) {
      this.#place = Math.floor(((performance.now() - this.#began) / 1000) * this.clip.rate) % count;
    }
    return Math.min(this.#place, Math.max(0, count - 1));
  }
}

/** A picture from the server. @param {string} address @param {AbortSignal} [signal] @returns {Promise<ImageBitmap>} */
export async function fetched(address, signal) {
  const answer = await fetch(address, { signal });
  if (!answer.ok) throw new Error(`the picture cannot be made (${answer.status})`);
  return createImageBitmap(await answer.blob());
}
