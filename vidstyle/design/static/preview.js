// The preview: frames of the film, rendered in this browser or by the server.

import { get, make, resize } from "./elements.js";
import { Player } from "./player.js";
import { PictureView } from "./picture.js";
import { Restyler } from "./restyle.js";

/** @typedef {import("./player.js").Clip} Clip */
/** @typedef {"page" | "server"} Where */
/** @typedef {import("./socket.js").Packet} Packet */

/** Types of the pictures from the server. */
export const PACKET = { source: 1, styled: 2, step: 3, exact: 4, style: 5, steady: 6, faces: 7, opened: 8 };

/** Preview sizes on offer: lengths of the shorter side in pixels. */
const PREVIEW_SIDES = [180, 270, 360, 540, 720, 1080, 1440, 2160];
/** The server accepts no smaller size. */
const MIN_SIDE = 64;
/** Time from a change of the window or the zoom until the preview gets the size that is shown. */
const FIT_MS = 300;
/**
 * A still picture is rendered at its own size up to this one, however small it is shown: marks have lengths in pixels, so
 * that a smaller picture would have coarser ones.
 */
const FINAL_SIDE = 1080;
/** Time without a new picture after which `onsettled` is called. */
const SETTLED_MS = 160;
/** Time from a change of the steps until its rendering is announced. */
const NOTED_MS = 600;
/** Returns the address of the picture that stands for a clip. @param {Clip} clip */
export const glanceAt = ({ name, count }) => `glance.jpg?${new URLSearchParams({ of: `${count} ${name}` })}`;
/** Longest wait of `check` for the full-size picture. */
const MAX_CHECK_MS = 20_000;

/** Requests frames, renders them and shows the result. */
export class Preview {
  /** @type {Where} */
  where;
  side = FINAL_SIDE;
  /** The preview size that the user chose; 0: the size that fits. */
  chosenSide = 0;
  /** The soloed step. @type {number | null} */
  solo = null;
  /** The current frame of the source. @type {ImageBitmap | null} */
  source = null;
  /** The current frame as rendered by the server: always, or as the style needs the server. @type {ImageBitmap | null} */
  styled = null;
  #styledRevision = 0;
  /** The revision of the document that the picture shows. */
  revision = 0;
  /** The faces of a frame in finer detail, rendered by the server, to be laid over it. @type {{number: number, picture: ImageBitmap} | null} */
  #faces = null;
  /** What the result is compared with. @type {"source" | "opened"} */
  against = "source";
  /** The number of the frame in `source`: after a pause, the player may lack the last ones. */
  #sourceNumber = 0;
  /** The frame that is shown, or asked for, in the style as opened. @type {number | null} */
  #openedNumber = null;
  #result = make("canvas");
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #timer;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #fitting;
  #packets = Promise.resolve();
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #noting;
  /** Is called with the exact picture that `check` requests. @type {(packet: Packet) => void} */
  #takeExact = () => {};

  /**
   * @param {import("./session.js").Session} session
   * @param {object} handlers
   * @param {() => void} handlers.onchange is called when the film position or the view has changed
   * @param {() => void} handlers.onsettled is called once the picture stops changing
   */
  constructor(session, handlers) {
    this.session = session;
    this.handlers = handlers;
    this.view = new PictureView(/** @type {HTMLCanvasElement} */ (get("picture")), get("divider"), () => this.#changed());
    this.player = new Player((kind, fields) => session.ask(kind, fields), handlers.onchange);
    this.restyler = new Restyler(() => this.restyle(), session.onerror);
    this.where = /** @type {Where} */ (this.restyler.isFast ? "page" : "server");
    session.on("plan", (plan) => {
      this.styled = null; // shown until the next picture
      if (plan.plan?.server.includes("masks")) this.renderIn("server", this.side);
      return this.restyler.take(plan);
    });
    session.on("clip", (clip) => this.#open(clip));
    session.on("picture", (packet) => {
      this.#packets = this.#packets.then(() => this.#take(packet)).catch(() => {});
    });
  }

  /** Tells the server which pictures this page needs. */
  watch() {
    return this.session.ask("watch", { solo: this.solo, side: this.side, where: this.where });
  }

  /** The preview sizes for this film: its own is the largest. */
  get sides() {
    const own = Math.max(MIN_SIDE, Math.min(...this.view.size, PREVIEW_SIDES[PREVIEW_SIDES.length - 1]));
    return [...PREVIEW_SIDES.filter((each) => each < own), own];
  }

  /** The shorter side of the picture on the screen, in its pixels; at most the side of the film. */
  get #shownSide() {
    return Math.min(...this.view.size) * Math.min(1, this.view.scale * devicePixelRatio);
  }

  /** Says that a changed picture is on its way, if it takes long; the next picture ends that. */
  announce() {
    clearTimeout(this.#noting);
    this.#noting = setTimeout(() => this.#note("Rendering the style…"), NOTED_MS);
  }

  /** Ends that if there will be no picture. */
  withdraw() {
    clearTimeout(this.#noting);
    this.#fitSoon();
  }

  /** @param {string} text */
  #note(text) {
    if (this.player.playing || !this.view.source) return;
    get("draft-note").textContent = text;
    get("draft-note").hidden = false;
  }

  /** Follows a change of the mode, the zoom or the window. */
  #changed() {
    this.#askOpened();
    this.handlers.onchange();
    this.#fitSoon();
  }

  /** The size at which a still picture is what the film becomes. */
  get #finalSide() {
    return this.#offered(Math.max(FINAL_SIDE, this.#shownSide));
  }

  /** Returns the smallest size on offer that has so many lines, or the largest. @param {number} lines */
  #offered(lines) {
    return this.sides.find((each) => each >= lines) ?? this.sides[this.sides.length - 1];
  }

  /** The preview size that fits best: a playing film is rendered at its size on the screen. */
  get #fittingSide() {
    if (this.chosenSide) return this.chosenSide;
    return this.player.playing ? this.#offered(this.#shownSide) : this.#finalSide;
  }

  /** Renders at the size that fits, a moment after it changes, and marks drafts until then. */
  #fitSoon() {
    if (!this.source || !this.view.canvas.clientWidth) return;
    const { result } = this.view;
    if (result) get("draft-note").textContent = "Draft";
    if (result) get("draft-note").hidden = this.player.playing || Math.min(...result.size) >= this.#finalSide;
    if (this.#fittingSide === this.side || this.#fitting) return;
    this.#fitting = setTimeout(() => {
      this.#fitting = undefined;
      if (this.#fittingSide !== this.side) this.renderIn(this.where, this.#fittingSide);
    }, FIT_MS);
  }

  /** @param {Where} where @param {number} side */
  renderIn(where, side) {
    this.where = where;
    this.side = side;
    return this.watch().then(() => this.refresh());
  }

  /** Shows the output of a step. @param {number | null} step null: the result */
  showStep(step) {
    this.solo = step;
    return this.watch();
  }

  /** Compares the result with the source, or with the style as opened. @param {"source" | "opened"} against */
  compareWith(against) {
    this.against = against;
    this.#dropOpened();
    this.#askOpened();
    this.#changed();
    this.view.draw();
  }

  /** Asks for the current frame in the style as opened, if it is compared and stands still. */
  #askOpened() {
    const number = this.#sourceNumber;
    if (this.against !== "opened" || this.player.playing || !this.source || this.#openedNumber === number || this.view.mode === "result") return;
    this.#openedNumber = number;
    this.session.ask("opened", { number, side: this.#finalSide });
  }

  #dropOpened() {
    this.#openedNumber = null;
    this.view.opened = null;
  }

  /** Shows a frame in the style as opened. @param {Packet} packet */
  async #takeOpened({ number, file }) {
    const picture = await createImageBitmap(file);
    if (number !== this.#openedNumber || this.against !== "opened") return picture.close();
    this.view.opened = { picture, size: [picture.width, picture.height] };
    this.#changed();
    this.view.draw();
  }

  /** Requests the current frame again. */
  refresh() {
    if (!this.player.playing) this.player.show(this.player.number);
  }

  /** Shows the original until the first picture in the style that was opened. */
  begin() {
    this.view.hold(false);
    this.restyler.forget();
    this.#forget();
    this.refresh();
  }

  #forget() {
    this.#dropOpened();
    this.styled?.close();
    this.styled = null;
    this.#put(null);
    this.#showSource();
  }

  /** Replaces the result, and frees the memory of the one before. @param {import("./picture.js").Shown | null} shown */
  #put(shown) {
    const before = this.view.result?.picture;
    this.view.result = shown;
    if (before instanceof ImageBitmap && before !== shown?.picture && before !== this.styled) before.close();
  }

  /** Shows the source, and says so, until there is a result. */
  #showSource() {
    if (this.view.result) return;
    const note = get("draft-note");
    note.textContent = "Original. Rendering the style…";
    note.hidden = !this.view.source;
    this.handlers.onchange();
    this.view.draw();
  }

  /** Shows an approximate picture of a clip until its first frame arrives. @param {Clip} clip */
  async #glance(clip) {
    const picture = make("img", { src: glanceAt(clip) });
    await picture.decode();
    if (this.source || this.player.clip !== clip) return;
    this.view.source = { picture, size: [picture.naturalWidth, picture.naturalHeight] };
    this.#showSource();
  }

  /** @param {Clip} clip */
  #open(clip) {
    const { name, count } = this.player.clip;
    if (name !== clip.name || count !== clip.count) {
      this.source?.close();
      this.source = this.view.source = null;
      this.#forget();
    }
    this.view.size = clip.size;
    this.restyler.restart();
    this.player.open(clip);
    this.view.setZoom(null);
    this.#glance(clip).catch(() => {}); // a camera that was lost, which the next frame reports
    if (clip.live || this.#fittingSide === this.side) this.refresh();
    else this.renderIn(this.where, this.#fittingSide); // no draft at the size of the clip before it
  }

  /** @param {Packet} packet */
  async #take(packet) {
    const { type, number, revision, file } = packet;
    if (type === PACKET.exact) return this.#takeExact(packet);
    if (type === PACKET.opened) return this.#takeOpened(packet);
    if (type !== PACKET.source && type !== PACKET.styled && type !== PACKET.steady && type !== PACKET.faces) return;
    const picture = await createImageBitmap(file);
    if (type === PACKET.steady) return this.#show(picture, revision);
    if (type === PACKET.faces) {
      this.#faces?.picture.close();
      this.#faces = { number, picture };
      return this.restyle();
    }
    if (this.player.playing && number < this.player.number) this.restyler.restart();
    this.player.shown(number);
    if (type === PACKET.source) {
      if (number !== this.#openedNumber) this.#dropOpened();
      this.source?.close();
      this.#sourceNumber = number;
      this.source = picture;
      this.view.source = { picture, size: [picture.width, picture.height] };
      this.#showSource();
    } else {
      if (this.styled !== this.view.result?.picture) this.styled?.close();
      this.styled = picture;
      this.#styledRevision = revision;
    }
    this.restyle();
  }

  /** Renders the current frame. */
  restyle() {
    if (!this.source) return;
    if (this.where === "server" || this.styled) {
      if (this.styled) this.#show(this.styled, this.#styledRevision);
      return;
    }
    const time = this.player.playing ? this.player.time(this.player.number) : null;
    const purpose = this.solo === null ? "main" : "solo";
    const { width, height } = this.source;
    resize(this.#result, [width, height]);
    if (!this.restyler.draw(purpose, this.source, time, this.#result)) return;
    if (!this.player.playing && this.#faces?.number === this.#sourceNumber)
      /** @type {CanvasRenderingContext2D} */ (this.#result.getContext("2d")).drawImage(this.#faces.picture, 0, 0, width, height);
    this.#show(this.#result, this.restyler.revisions.get(purpose) ?? 0);
  }

  /** @param {ImageBitmap | HTMLCanvasElement} picture @param {number} revision of the document that it shows */
  #show(picture, revision) {
    const isFirst = !this.view.result;
    clearTimeout(this.#noting);
    this.revision = revision;
    this.#put({ picture, size: [picture.width, picture.height] });
    this.view.draw();
    if (isFirst) this.handlers.onchange(); // there is something to label
    this.#fitSoon();
    this.view.canvas.dataset.lines = String(Math.min(picture.width, picture.height));
    this.view.canvas.dataset.revision = String(this.session.state?.revision ?? "");
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => {
      this.#askOpened();
      this.handlers.onsettled();
    }, SETTLED_MS);
  }

  /**
   * Compares the preview with the exact picture from the server, which has its final size.
   * @returns {Promise<{largest: number, share: number} | null>} the largest difference, 0 to 255, and the
   *   fraction of values that differ by more than 1
   */
  async check() {
    await this.player.pause();
    /** @type {Promise<Packet>} */
    const packet = new Promise((done) => (this.#takeExact = done));
    const side = Math.max(this.side, this.#finalSide);
    if (!(await this.session.ask("check", { side })) || !this.view.result) return null;
    const exact = await createImageBitmap((await packet).file);
    // The server sends a small picture first if rendering is slow.
    for (let waited = 0; !this.chosenSide && this.view.result.size[0] !== exact.width && waited < MAX_CHECK_MS; waited += 50)
      await new Promise((done) => setTimeout(done, 50));
    const [one, other] = [exact, this.view.result.picture].map((picture) => pixelsOf(picture, exact.width, exact.height));
    let [largest, off] = [0, 0];
    for (let at = 0; at < one.length; at++) {
      const difference = Math.abs(one[at] - other[at]);
      if (difference > largest) largest = difference;
      if (difference > 1) off += 1;
    }
    return { largest, share: off / (0.75 * one.length) };
  }
}

/** Returns the RGBA values of a picture. @param {CanvasImageSource} picture @param {number} width @param {number} height */
function pixelsOf(picture, width, height) {
  const context = /** @type {CanvasRenderingContext2D} */ (make("canvas", { width, height }).getContext("2d", { willReadFrequently: true }));
  context.drawImage(picture, 0, 0, width, height);
  return context.getImageData(0, 0, width, height).data;
}
