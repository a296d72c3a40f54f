// The lightbox: one style enlarged, with before and after, fine tuning, saving and export.

import { Divider } from "./divider.js";
import { get, make, press, resize, saveAs } from "./elements.js";
import { switchOriginal } from "./original_button.js";
import { Outcome } from "./outcome.js";
import { SHARED_KEYS } from "./shared_keys.js";
import { fetchPicture, SourceFrames } from "./source_frames.js";
import { nameOf, summaryOf } from "./tile_names.js";
import { TuningPad } from "./tuning_pad.js";
import { WaitingNote } from "./waiting_note.js";

/** @typedef {import("./explore_types.js").Tile} Tile */
/** @typedef {import("./explore_types.js").Clip} Clip */
/** @typedef {import("./painters.js").Subject} Subject */

/** Words of the button that saves, and of it when the file exists. */
const [SAVE, REPLACE] = ["Save look", "Replace"];
/** Length of a proposed name, which the field shows whole. */
const MAX_NAME_LENGTH = 26;
const LAYER_NAMES = { base: "First", background: "Background", lines: "Lines" };
const canvas = /** @type {HTMLCanvasElement} */ (get("large"));
const dialog = /** @type {HTMLDialogElement} */ (get("lightbox"));
/** @param {HTMLCanvasElement} picture */
function copyOf(picture) {
  const copy = make("canvas", { width: picture.width, height: picture.height });
  copy.getContext("2d")?.drawImage(picture, 0, 0);
  return copy;
}

/** Returns a name for files: the parts of a text that fit into it, or words of the first part. @param {string} text */
export function fileName(text) {
  const parts = text.toLowerCase().split(",");
  while (parts.length > 1 && parts.join("").length > MAX_NAME_LENGTH) parts.pop();
  const words = parts.join(" ").split(/[^a-z0-9]+/).filter(Boolean);
  while (words.length > 1 && words.join("-").length > MAX_NAME_LENGTH) words.pop();
  return words.join("-").slice(0, MAX_NAME_LENGTH);
}

/** The enlarged view of a tile. */
export class Lightbox {
  /** @type {Tile | null} */
  tile = null;
  /** The tile to compare with; null: the unchanged clip. @type {Tile | null} */
  other = null;
  held = false;
  /** Whether a film is being rendered. */
  rendering = false;
  /** The index of the current frame. */
  #place = -1;
  #scratch = document.createElement("canvas");
  /** The small picture of the tile, shown until the large one is there. @type {HTMLCanvasElement | null} */
  #draft = null;
  /** The original of a photograph, until its frame has arrived. @type {ImageBitmap | null} */
  #glance = null;
  #moving = false;
  #note = new WaitingNote(get("draft"));
  /** The subject shown, until the next one is ready. @type {Subject | null} */
  #shown = null;

  /**
   * @param {object} handlers
   * @param {import("./tuning_pad.js").Ask} handlers.ask
   * @param {(tile: number) => Subject} handlers.subjectOf
   * @param {(source: SourceFrames) => import("./painters.js").PagePainter | import("./painters.js").ServerPainter} handlers.painterOf
   * @param {() => number} handlers.side returns the shorter side at which to draw
   * @param {() => boolean} handlers.isPlaying whether the tiles play
   * @param {(tile: number) => void} handlers.onlike
   * @param {(tile: number) => Promise<boolean>} handlers.onstar keeps a tile or stops keeping it; resolves to whether it is kept
   * @param {(tile: number) => boolean} handlers.isKept
   * @param {(text: string) => void} handlers.say shows a message while no tile is open
   */
  constructor(handlers) {
    this.handlers = handlers;
    this.source = new SourceFrames(() => (this.dirty = true));
    this.painter = handlers.painterOf(this.source);
    this.dirty = true;
    /** @type {Clip | null} */
    this.clip = null;
    this.divider = new Divider(canvas, get("divider"), () => (this.dirty = true));
    this.pad = new TuningPad(handlers.ask, () => this.#tune());
    this.outcome = new Outcome(handlers.say, (file) => this.#act(async () => void (await handlers.ask("reveal", { file }))));
    this.#listen();
  }

  get isOpen() {
    return dialog.open;
  }

  /**
   * Opens a tile.
   * @param {Tile} tile
   * @param {Clip} clip
   * @param {Tile | null} other the tile to compare with; null: the unchanged clip
   * @param {HTMLCanvasElement | null} small its small picture, shown until the large one is there
   */
  open(tile, clip, other = null, small = null) {
    const isNew = this.clip !== clip || !this.source.pictures.length;
    Object.assign(this, { tile, other, clip });
    if (!dialog.open) dialog.showModal();
    if (other) this.divider.move(0.5);
    this.#play(this.handlers.isPlaying());
    this.#shown = null;
    this.hold(false);
    get("draft").hidden = !small;
    this.#note.begin("Rendering in full size…");
    this.#draft = small && copyOf(small);
    if (isNew) this.source.open(clip, this.handlers.side());
    if (isNew) this.#loadGlance(clip);
    this.painter.keep(new Set());
    this.#prepare(this.handlers.subjectOf(tile.tile));
    if (other) this.painter.prepare(this.handlers.subjectOf(other.tile), this.handlers.side());
    this.pad.load(tile);
    this.#describe(tile, clip);
    get("render").after(get("progress"));
    get("like").focus();
  }

  /** @param {Tile} tile @param {Clip} clip */
  #describe(tile, clip) {
    const { other } = this;
    get("lightbox-name").textContent = get("right-name").textContent = nameOf(tile);
    get("left-name").textContent = other ? nameOf(other) : "Original";
    const origin = tile.change ? [`Compared with your choice: ${tile.change.toLowerCase()}`, tile.kind === "step" && tile.steps] : [summaryOf(tile)];
    get("how").textContent = other ? `Right: ${nameOf(tile)}, compared with, left: ${nameOf(other)}` : [...origin, tile.blocks].filter(Boolean).join(". ");
    const rows = Object.entries(tile.layers).flatMap(([layer, blocks]) => [
      make("dt", { textContent: LAYER_NAMES[/** @type {keyof typeof LAYER_NAMES} */ (layer)] }),
      make("dd", { textContent: blocks.filter(Boolean).join(", ") }),
    ]);
    get("layers").replaceChildren(...rows);
    get("design").hidden = !clip.design;
    get("targets").replaceChildren(...clip.targets.map(({ kind, title, use, help }) => make("button", { onclick: () => this.export(kind) }, make("b", { textContent: title }), make("span", { textContent: `${use}.` }), make("span", { className: "quiet", textContent: `A .${kind} file: ${help}` }))));
    /** @type {HTMLDetailsElement} */ (get("exports")).open = false;
    this.#showRender(clip);
    /** @type {HTMLInputElement} */ (get("name")).value = fileName(nameOf(tile));
    this.outcome.report("");
    get("save").textContent = SAVE;
    this.#mark();
  }

  #mark() {
    const kept = this.tile !== null && !this.pad.moved && this.handlers.isKept(this.tile.tile);
    press(get("keep"), kept);
    get("keep-label").textContent = kept ? "Kept" : "Keep";
    press(get("split"), this.divider.split !== null);
    this.dirty = true;
  }

  /** Draws the picture if it has changed or the film plays. */
  draw() {
    if (!dialog.open || !this.clip) return;
    if (!this.#shown) return this.#drawDraft();
    const before = this.other && this.handlers.subjectOf(this.other.tile);
    const counts = [this.painter.count(this.#shown), before ? this.painter.count(before) : this.source.ready];
    const place = this.source.due(Math.min(...counts));
    if (!this.dirty && place === this.#place) return;
    [this.#place, this.dirty] = [place, false];
    if (!this.held && this.painter.draw(this.#shown, place, canvas)) this.#endDraft();
    this.#compare(before, place);
  }

  #endDraft() {
    get("draft").hidden = true;
    this.#note.end("");
  }

  /** Draws the small picture, if it or what it is compared with has changed. */
  #drawDraft() {
    if (!this.dirty || !this.#draft) return;
    this.dirty = false;
    resize(canvas, [this.#draft.width, this.#draft.height]);
    canvas.getContext("2d")?.drawImage(this.#draft, 0, 0);
    this.#compare(this.other && this.handlers.subjectOf(this.other.tile), 0);
  }

  /** Draws the picture before, left of the divider or instead. @param {Subject | null} before @param {number} place */
  #compare(before, place) {
    if (this.held) this.#drawBefore(before, place, canvas);
    else if (this.divider.split !== null) {
      [this.#scratch.width, this.#scratch.height] = [canvas.width, canvas.height];
      this.#drawBefore(before, place, this.#scratch);
      this.divider.paint(this.#scratch, [canvas.width, canvas.height]);
    }
    this.divider.place();
    get("divider").hidden ||= this.held;
  }

  /** Fetches the preview of a photograph; the preview of a film shows another frame. @param {Clip} clip */
  async #loadGlance(clip) {
    this.#glance?.close();
    this.#glance = null;
    if (clip.count > 1) return;
    this.#glance = await fetchPicture("glance.jpg").catch(() => null);
    this.dirty = true;
  }

  /** @param {Subject | null} before @param {number} place @param {HTMLCanvasElement} onto */
  #drawBefore(before, place, onto) {
    const picture = this.source.pictures[place] ?? this.#glance;
    if (before) this.painter.draw(before, place, onto);
    else if (picture) onto.getContext("2d")?.drawImage(picture, 0, 0, onto.width, onto.height);
  }

  /** Draws the point of the tuning pad, and after that the one to which it has moved meanwhile. */
  async #tune() {
    this.#mark();
    if (this.#moving) return;
    this.#moving = true;
    let drawn;
    while (drawn !== this.pad.at && this.pad.subject) {
      drawn = this.pad.at;
      await this.#prepare(this.pad.subject).catch(() => {});
    }
    this.#moving = false;
  }

  /** @param {Subject} subject */
  async #prepare(subject) {
    await this.painter.prepare(subject, this.handlers.side());
    this.#shown = subject;
    const before = this.other ? [this.handlers.subjectOf(this.other.tile).name] : [];
    this.painter.keep(new Set([subject.name, ...before]));
    this.dirty = true;
  }

  /** Resolves to the number of the tile; turns a tuned style into a new tile first. */
  async #tileNumber() {
    if (!this.tile) throw new Error("No style is open.");
    if (this.pad.moved) this.tile = { ...this.tile, tile: await this.pad.keep(), kind: "tuned", parents: [this.pad.tile?.name ?? ""] };
    return this.tile.tile;
  }

  // Actions

  /** @param {string} done what was done with the look @param {{file: string, number?: number}} answer with the number of a rendered file */
  #showFile(done, { file, number }) {
    this.outcome.reportFile(done, file, { canReveal: Boolean(this.clip?.reveal), address: number === undefined ? "" : `rendered?of=${number}` });
  }

  /** Runs an action on the tile and reports its outcome. @param {(tile: number) => Promise<void>} action @param {string} [doing] what it does, if it takes long */
  async #act(action, doing = "") {
    try {
      if (doing) this.outcome.report(doing, "spinning");
      await action(await this.#tileNumber());
      this.#mark();
    } catch (error) {
      this.outcome.report(/** @type {Error} */ (error).message, "alarm");
    }
  }

  async save() {
    const name = /** @type {HTMLInputElement} */ (get("name"));
    const button = get("save");
    if (!name.value.trim()) {
      this.outcome.report("Type a name for the look first.", "alarm");
      return name.focus();
    }
    const look = name.value.trim();
    const overwrite = button.textContent === REPLACE;
    await this.#act(async (tile) => {
      try {
        const answer = await this.handlers.ask("save", { tile, name: look, overwrite });
        button.textContent = SAVE;
        this.#showFile("Saved", answer);
      } catch (error) {
        if (!/exists/.test(String(error))) throw error;
        button.textContent = REPLACE;
        this.outcome.report(`Replace ${look}? A look of this name is in ${this.clip?.folder}. Press ${REPLACE}, or type another name.`);
      }
    }, `Saving ${look}…`);
  }

  /** The name in the field, else a name derived from the style. */
  get name() {
    const given = /** @type {HTMLInputElement} */ (get("name")).value.trim();
    return given || (this.tile?.name ?? "style").replace(/[^A-Za-z0-9_-]+/g, "-");
  }

  /** Writes the style for other programs. @param {string} kind of a target */
  export(kind) {
    return this.#act(async (tile) => this.#showFile("Exported", await this.handlers.ask("export", { tile, name: this.name, kind })), `Exporting ${this.name}.${kind}…`);
  }

  async render() {
    const stem = (this.clip?.name ?? "film").replace(/\.\w+$/, "").replace(/[^A-Za-z0-9_-]+/g, "-").slice(0, 30);
    const clip = /** @type {Clip} */ (this.clip);
    this.rendering = true;
    this.#showRender(clip);
    this.progress({});
    const doing = `Rendering ${clip.name} in this look…`;
    await this.#act(async (tile) => this.#showRendered(await this.handlers.ask("render", { tile, name: `${stem}-${this.name}`.slice(0, 64) })), doing);
    this.rendering = false;
    this.#showRender(clip);
  }

  /** Downloads a rendered picture, as other pages do, or shows where a rendered film is. @param {{file: string, number: number}} answer */
  #showRendered(answer) {
    if ((this.clip?.count ?? 1) > 1) return this.#showFile("Rendered", answer);
    const name = answer.file.replace(/^.*[\\/]/, "");
    saveAs(`rendered?of=${answer.number}`, name);
    this.outcome.report(`${name} is in your downloads.`);
  }

  /** Shows whether a film can be rendered or is being rendered. @param {Clip} clip */
  #showRender(clip) {
    const button = /** @type {HTMLButtonElement} */ (get("render"));
    button.disabled = !clip.render || this.rendering;
    button.title = clip.count > 1 ? `Write the whole film in this look to ${clip.output}` : "Save the picture in this look to your downloads";
    button.textContent = this.rendering ? "Rendering…" : clip.count > 1 ? "Render film" : "Save picture";
    get("progress").hidden = !this.rendering;
  }

  /** @param {{fraction?: number | null, frame?: number, fps?: number}} progress */
  progress(progress) {
    const bar = /** @type {HTMLProgressElement} */ (document.querySelector("#progress progress"));
    bar.value = progress.fraction ?? 0;
    /** @type {HTMLElement} */ (bar.nextElementSibling).textContent = `Rendering: ${Math.round(100 * (progress.fraction ?? 0))} %`;
  }

  like() {
    return this.#act(async (tile) => {
      dialog.close();
      this.handlers.onlike(tile);
    });
  }

  star() {
    return this.#act(async (tile) => void (await this.handlers.onstar(tile)));
  }

  toggleSplit() {
    this.divider.toggle();
    this.#mark();
  }

  /** @param {boolean} on */
  #play(on) {
    this.source.playing = on;
    press(get("play-large"), on);
    get("play-large").hidden = (this.clip?.count ?? 1) < 2;
    this.painter.resume();
  }

  /** @param {boolean} on */
  hold(on) {
    this.held = on;
    press(get("hold"), on);
    this.dirty = true;
  }

  #listen() {
    get("close").onclick = () => dialog.close();
    dialog.addEventListener("close", () => this.#endDraft());
    dialog.addEventListener("close", () => get("rail").prepend(get("progress")));
    dialog.addEventListener("close", () => this.source.open({ .../** @type {Clip} */ (this.clip), frames: [] }, 180));
    get("like").onclick = () => this.like();
    get("keep").onclick = () => this.star();
    get("split").onclick = () => this.toggleSplit();
    get("play-large").onclick = () => this.#play(!this.source.playing);
    switchOriginal(get("hold"), () => this.held, (on) => this.hold(on));
    get("saving").addEventListener("submit", (event) => {
      event.preventDefault();
      this.save();
    });
    get("name").addEventListener("focus", () => /** @type {HTMLInputElement} */ (get("name")).select());
    get("name").addEventListener("input", () => (get("save").textContent = SAVE));
    get("render").onclick = () => this.render();
    get("cancel").onclick = () => this.handlers.ask("cancel");
    get("design").onclick = () => this.#act(async (tile) => void window.open((await this.handlers.ask("design", { tile })).url, "_blank", "noopener"));
    this.divider.listen();
    dialog.addEventListener("keydown", (event) => this.#key(event));
    dialog.addEventListener("keyup", (event) => event.key.toLowerCase() === SHARED_KEYS.original && this.hold(false));
    addEventListener("resize", () => (this.dirty = true));
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const target = /** @type {HTMLElement} */ (event.target);
    if (event.ctrlKey || event.metaKey || event.altKey || target.matches("input")) return;
    if (this.pad.press(event)) return event.preventDefault();
    if (event.key === "Enter" && !target.matches("button")) this.like();
    else if (event.key.toLowerCase() === SHARED_KEYS.save) this.star();
    else if (event.key === SHARED_KEYS.compare) this.toggleSplit();
    else if (event.key === SHARED_KEYS.original) this.hold(true);
    else if (event.key === SHARED_KEYS.play) this.#play(!this.source.playing);
    else return;
    event.preventDefault();
  }
}
