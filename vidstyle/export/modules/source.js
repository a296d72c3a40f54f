// The photograph, film or camera that a page restyles.

import { make } from "./elements.js";

/** @typedef {HTMLVideoElement | HTMLImageElement} Picture */

/** The position of a film that does not play: its first frame is often blank. */
const FIRST_POSITION_RATIO = 0.4;

/** @param {MediaProvider | null} stream */
function stop(stream) {
  if (stream instanceof MediaStream) stream.getTracks().forEach((track) => track.stop());
}

/** Returns the size of a video or image; zeros if it has no picture yet. @param {Picture} picture @returns {[number, number]} */
function frameSize(picture) {
  return picture instanceof HTMLVideoElement ? [picture.videoWidth, picture.videoHeight] : [picture.naturalWidth, picture.naturalHeight];
}

/** Decodes a photograph. @param {string} src @returns {Promise<HTMLImageElement>} */
export async function loadPicture(src) {
  const picture = make("img", { src });
  await picture.decode().catch(() => {
    throw new Error("this browser cannot show this file");
  });
  return picture;
}

export class Source {
  /** The element to restyle; null before the first is opened. @type {Picture | null} */
  picture = null;
  /** The name of its file without the extension; empty if it has none. */
  name = "";
  /** Whether a film starts to play when it is opened. */
  autoplay = true;

  /**
   * @param {object} events
   * @param {() => void} events.onopen is called when another picture is shown
   * @param {() => void} events.onplay is called when a film starts to play or is paused
   * @param {() => void} events.onframe is called for each new frame
   * @param {() => void} events.onjump is called before the frame after a jump in a film
   * @param {(text: string, seconds?: number) => void} events.report shows a message
   */
  constructor({ onopen, onplay, onframe, onjump, report }) {
    this.onopen = onopen;
    this.onplay = onplay;
    this.onframe = onframe;
    this.onjump = onjump;
    this.report = report;
  }

  /** The video, unless this is a photograph. */
  get video() {
    return this.picture instanceof HTMLVideoElement ? this.picture : null;
  }

  /** The video, if it is a film, with a position. */
  get film() {
    return this.video?.srcObject ? null : this.video;
  }

  /** Width and height. @returns {[number, number]} */
  get size() {
    return this.picture ? frameSize(this.picture) : [0, 0];
  }

  /** Presentation time in seconds; null for a photograph. */
  get time() {
    return this.video && (this.film ? this.video.currentTime : performance.now() / 1000);
  }

  /** Shows a picture instead of the present one. @param {Picture} next @param {string} [name] of its file, without the extension */
  show(next, name = "") {
    this.name = name;
    this.video?.pause();
    stop(this.video?.srcObject ?? null);
    this.picture = next;
    this.onopen();
    if (next instanceof HTMLVideoElement) this.#follow(next);
    this.onframe();
  }

  /** Opens a photograph or a film. @param {File} file */
  async openFile(file) {
    const src = URL.createObjectURL(file);
    const name = file.name.replace(/\.[^.]+$/, "");
    try {
      if (file.type.startsWith("video/")) await this.#openFilm(make("video", { src, loop: true, playsInline: true }), name);
      else this.show(await loadPicture(src), name);
    } catch (error) {
      this.report(`${file.name}: ${/** @type {Error} */ (error).message}`);
    }
  }

  /** @param {HTMLVideoElement} video @param {string} name */
  async #openFilm(video, name) {
    for (const event of ["play", "pause"]) {
      video.addEventListener(event, () => {
        this.#markPlaying(video);
        if (this.picture === video) this.onplay();
      });
    }
    video.addEventListener("seeked", () => {
      this.onjump();
      this.onframe();
    });
    await new Promise((done, fail) => {
      video.addEventListener(this.autoplay ? "loadeddata" : "seeked", done);
      if (!this.autoplay) video.addEventListener("loadedmetadata", () => (video.currentTime = Number.isFinite(video.duration) ? FIRST_POSITION_RATIO * video.duration : 0));
      video.addEventListener("error", () => fail(new Error("this browser cannot play this file")));
    });
    this.show(video, name);
    this.#markPlaying(video);
    if (!this.autoplay) return;
    await video.play().catch(() => {
      video.muted = true;
      return video.play();
    });
  }

  /** Starts a camera: the first, the one with this number (from 1), or the one whose name contains this text. */
  async openCamera(wanted = "") {
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
      this.show(video);
    } catch (error) {
      this.report(`The camera cannot be used: ${/** @type {Error} */ (error).message}`, 0);
    }
  }

  /** Plays or pauses a film. */
  toggle() {
    if (this.film?.paused) this.film.play();
    else this.film?.pause();
  }

  /** @param {HTMLVideoElement} video */
  #follow(video) {
    const next = () => {
      if (this.picture !== video) return;
      this.onframe();
      schedule();
    };
    const schedule = () => ("requestVideoFrameCallback" in video ? video.requestVideoFrameCallback(next) : requestAnimationFrame(next));
    schedule();
  }

  /** @param {HTMLVideoElement} video */
  #markPlaying(video) {
    document.body.classList.toggle("playing", !video.paused);
    document.body.classList.toggle("paused", video.paused);
  }

  /**
   * Opens files that are dropped or pasted anywhere on the page, or chosen with an `<input type=file>`.
   * @param {HTMLInputElement} input
   */
  listen(input) {
    const open = (/** @type {FileList | undefined | null} */ files) => void (files?.[0] && this.openFile(files[0]));
    input.onchange = () => open(input.files);
    for (const kind of /** @type {const} */ (["dragover", "dragleave", "drop"])) {
      addEventListener(kind, (event) => {
        event.preventDefault();
        document.body.classList.toggle("over", kind === "dragover");
        if (kind === "drop") open(event.dataTransfer?.files);
      });
    }
    addEventListener("paste", (event) => open(event.clipboardData?.files));
  }
}
