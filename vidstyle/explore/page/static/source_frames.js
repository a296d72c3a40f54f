// The excerpt of the clip that plays in the tiles, held by the page.

/** @typedef {import("./explore_types.js").Clip} Clip */

/** Fetches the frames of an excerpt and selects the one to show. */
export class SourceFrames {
  /** @type {Clip | null} */
  clip = null;
  /** The frames of the excerpt, in order. @type {(ImageBitmap | undefined)[]} */
  pictures = [];
  playing = true;
  #began = 0;
  #place = 0;
  #asked = 0;

  /** @param {() => void} onchange is called when a frame has arrived */
  constructor(onchange) {
    this.onchange = onchange;
  }

  /**
   * Opens another clip or another excerpt.
   * @param {Clip} clip
   * @param {number | null} side the shorter side; null if the frames are not needed
   */
  async open(clip, side) {
    const asked = ++this.#asked;
    for (const picture of this.pictures) picture?.close();
    this.clip = clip;
    this.pictures = [];
    this.#began = performance.now();
    for (const [place, frame] of side === null ? [] : clip.frames.entries()) {
      const picture = await fetchPicture(`frame.jpg?frame=${frame}&side=${side}`).catch(() => undefined);
      if (asked !== this.#asked) return picture?.close();
      this.pictures[place] = picture;
      this.onchange();
    }
  }

  /** The number of frames available without a gap from the first. */
  get ready() {
    const gap = this.pictures.findIndex((each) => !each);
    return gap < 0 ? this.pictures.length : gap;
  }

  /** Returns the index of the frame to show. @param {number} count the number of frames that can be shown */
  due(count) {
    if (this.playing && this.clip && count > 1) {
      this.#place = Math.floor(((performance.now() - this.#began) / 1000) * this.clip.rate) % count;
    }
    return Math.min(this.#place, Math.max(0, count - 1));
  }
}

/** Fetches a picture from the server. @param {string} address @param {AbortSignal} [signal] @returns {Promise<ImageBitmap>} */
export async function fetchPicture(address, signal) {
  const answer = await fetch(address, { signal });
  if (!answer.ok) throw new Error(`the server could not send the picture (${answer.status})`);
  return createImageBitmap(await answer.blob());
}
