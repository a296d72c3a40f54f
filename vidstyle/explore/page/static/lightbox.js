// The lightbox: one style enlarged, with before and after, fine tuning on a pad of two parameters, saving and export.

import { boxOf, Divider } from "./divider.js";
import { followPointer, get, make, press, resize } from "./elements.js";
import { SHARED_KEYS } from "./shared_keys.js";
import { SourceFrames } from "./source_frames.js";
import { nameOf, ownNameOf, rootOf, summaryOf } from "./tile_names.js";

/** @typedef {import("./explore_types.js").Tile} Tile */
/** @typedef {import("./explore_types.js").Clip} Clip */
/** @typedef {import("./painters.js").Subject} Subject */
/** @typedef {{label: string, path: string, low: number, high: number, whole: boolean, factor: boolean}} Axis */
/** @typedef {(kind: string, fields?: object) => Promise<any>} Ask */

/** Words of the button that saves, and of it when the file exists. */
const [SAVE, REPLACE] = ["Save look", "Replace"];
const MAX_NAME_LENGTH = 40;
const LAYER_NAMES = { base: "First", background: "Background", lines: "Lines" };
const canvas = /** @type {HTMLCanvasElement} */ (get("large"));
const dialog = /** @type {HTMLDialogElement} */ (get("lightbox"));
const pad = get("pad");
const point = get("point");

/** Returns the value at a position on an axis. @param {Axis} axis @param {number} place */
function valueAt(axis, place) {
  if (axis.factor) return axis.low * Math.pow(axis.high / axis.low, place);
  const value = axis.low + place * (axis.high - axis.low);
  return axis.whole ? Math.round(value) : value;
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
  /** @type {Axis[]} */
  axes = [];
  /** The point on the pad. @type {[number, number]} */
  at = [0.5, 0.5];
  /** Whether the point has left the position of the style. */
  moved = false;
  /** The tile that the pad tunes. @type {Tile | null} */
  padTile = null;
  /** The index of the current frame. */
  #place = -1;
  #scratch = document.createElement("canvas");
  #moving = false;
  /** The subject shown, until the next one is ready. @type {Subject | null} */
  #shown = null;

  /**
   * @param {object} handlers
   * @param {Ask} handlers.ask
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
    Object.assign(this, { tile, other, clip, moved: false });
    if (!dialog.open) dialog.showModal();
    if (other) this.divider.move(0.5);
    this.#play(this.handlers.isPlaying());
    this.#shown = null;
    get("draft").hidden = !small;
    if (small) {
      resize(canvas, [small.width, small.height]);
      canvas.getContext("2d")?.drawImage(small, 0, 0);
      this.divider.place();
    }
    if (isNew) this.source.open(clip, this.handlers.side());
    this.painter.keep(new Set());
    this.#prepare(this.handlers.subjectOf(tile.tile));
    if (other) this.painter.prepare(this.handlers.subjectOf(other.tile), this.handlers.side());
    this.#describe(tile, clip);
    get("render").after(get("progress"));
    get("like").focus();
    this.#loadPad(tile);
  }

  /** @param {Tile} tile @param {Clip} clip */
  #describe(tile, clip) {
    const { other } = this;
    get("lightbox-name").textContent = ownNameOf(tile);
    const isChanged = ownNameOf(tile) !== nameOf(tile);
    get("how").textContent = other ? `Right: ${nameOf(tile)}, compared with, left: ${nameOf(other)}` : [isChanged ? `Compared with your choice: ${nameOf(tile).toLowerCase()}` : summaryOf(tile), tile.blocks].filter(Boolean).join(". ");
    const rows = Object.entries(tile.layers).flatMap(([layer, blocks]) => [
      make("dt", { textContent: LAYER_NAMES[/** @type {keyof typeof LAYER_NAMES} */ (layer)] }),
      make("dd", { textContent: blocks.filter(Boolean).join(", ") }),
    ]);
    get("layers").replaceChildren(...rows);
    get("design").hidden = !clip.design;
    get("targets").replaceChildren(...clip.targets.map(({ kind, title, use, help }) => make("button", { onclick: () => this.export(kind) }, make("b", { textContent: title }), make("span", { textContent: `${use}.` }), make("span", { className: "quiet", textContent: `A .${kind} file: ${help}` }))));
    /** @type {HTMLDetailsElement} */ (get("exports")).open = false;
    this.#showRender(clip);
    /** @type {HTMLInputElement} */ (get("name")).value = (tile.look || nameOf(tile)).toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "").slice(0, MAX_NAME_LENGTH);
    get("outcome").textContent = "";
    get("save").textContent = SAVE;
    this.#mark();
  }

  #mark() {
    const kept = this.tile !== null && !this.moved && this.handlers.isKept(this.tile.tile);
    press(get("keep"), kept);
    press(get("split"), this.divider.split !== null);
    this.dirty = true;
  }

  /** Draws the picture if it has changed or the film plays. */
  draw() {
    if (!dialog.open || !this.#shown || !this.clip) return;
    const before = this.other && this.handlers.subjectOf(this.other.tile);
    const counts = [this.painter.count(this.#shown), before ? this.painter.count(before) : this.source.ready];
    const place = this.source.due(Math.min(...counts));
    if (!this.dirty && place === this.#place) return;
    [this.#place, this.dirty] = [place, false];
    if (this.held) return this.#drawBefore(before, place, canvas);
    if (this.painter.draw(this.#shown, place, canvas)) get("draft").hidden = true;
    if (this.divider.split !== null) {
      [this.#scratch.width, this.#scratch.height] = [canvas.width, canvas.height];
      this.#drawBefore(before, place, this.#scratch);
      this.divider.paint(this.#scratch, [canvas.width, canvas.height]);
    }
    this.divider.place();
    this.#placeNames();
  }

  /** @param {Subject | null} before @param {number} place @param {HTMLCanvasElement} onto */
  #drawBefore(before, place, onto) {
    const picture = this.source.pictures[place];
    if (before) this.painter.draw(before, place, onto);
    else if (picture) onto.getContext("2d")?.drawImage(picture, 0, 0, onto.width, onto.height);
  }

  /** Names both styles at the edges of the picture, if it is divided between two styles. */
  #placeNames() {
    const names = [get("left-name"), get("right-name")];
    const { tile, other } = this;
    for (const name of names) name.hidden = this.divider.split === null || !other;
    if (names[0].hidden || !tile || !other) return;
    const { x, y, width } = boxOf(canvas);
    names[0].textContent = nameOf(other);
    names[1].textContent = nameOf(tile);
    Object.assign(names[0].style, { left: `${x + 10}px`, top: `${y + 10}px` });
    Object.assign(names[1].style, { left: `${x + width - names[1].offsetWidth - 10}px`, top: `${y + 10}px` });
  }

  // Fine tuning

  /** @param {Tile} tile */
  async #loadPad(tile) {
    this.axes = [];
    this.padTile = tile;
    pad.classList.remove("ready");
    pad.setAttribute("aria-busy", "true");
    get("pad-note").textContent = "Finding two values to tune…";
    get("axes").replaceChildren();
    point.hidden = true;
    try {
      const { axes, start } = await this.handlers.ask("pad", { tile: tile.tile });
      if (this.padTile !== tile) return;
      [this.axes, this.at] = [axes, start];
      const samples = /** @type {HTMLImageElement} */ (get("samples"));
      samples.src = `pad.jpg?tile=${tile.tile}`;
      this.#placePoint();
      get("pad-note").textContent = "Drawing samples of both values…";
      await samples.decode();
      if (this.padTile === tile) pad.classList.add("ready");
    } catch (error) {
      if (this.padTile === tile) get("pad-note").textContent = "This look has no two values to tune.";
    }
    pad.setAttribute("aria-busy", "false");
  }

  #placePoint() {
    const [x, y] = this.at;
    point.hidden = false;
    // At an edge it stays whole.
    const within = (/** @type {number} */ part) => `clamp(.75rem, ${100 * part}%, 100% - .75rem)`;
    Object.assign(point.style, { left: within(x), top: within(1 - y) });
    const texts = this.axes.map((axis, each) => [
      `${each ? "↑" : "→"} ${axis.label}`,
      String(Number(valueAt(axis, this.at[each]).toPrecision(3))),
    ]);
    get("axes").replaceChildren(...texts.flatMap(([name, value]) => [make("dt", { textContent: name }), make("dd", { textContent: value })]));
    pad.setAttribute("aria-description", texts.map((each) => each.join(" ")).join(", "));
  }

  /** @param {number} x @param {number} y */
  async #moveTo(x, y) {
    if (!this.axes.length) return;
    const inside = (/** @type {number} */ part) => Math.min(1, Math.max(0, part));
    this.at = [inside(x), inside(y)];
    this.moved = true;
    this.#placePoint();
    this.#mark();
    if (this.#moving) return;
    this.#moving = true;
    let drawn;
    while (drawn !== this.at && this.padTile) {
      drawn = this.at;
      await this.#prepare(this.#tunedSubject(this.padTile.tile, drawn)).catch(() => {});
    }
    this.#moving = false;
  }

  /** @param {number} tile @param {[number, number]} at @returns {Subject} */
  #tunedSubject(tile, [x, y]) {
    return {
      name: `${tile}@${x},${y}`,
      plan: (side, whole) => this.handlers.ask("tune", { tile, x, y, side, whole }),
      address: (frame, side) => `tuned.jpg?tile=${tile}&x=${x}&y=${y}&frame=${frame}&side=${side}`,
    };
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
    if (this.moved && this.padTile) {
      const [x, y] = this.at;
      const { tile } = await this.handlers.ask("keep", { tile: this.padTile.tile, x, y });
      this.tile = { ...this.tile, tile, kind: "tuned", parents: [this.padTile.name] };
      this.moved = false;
    }
    return this.tile.tile;
  }

  // Actions

  /** @param {string} text @param {string} [kind] "alarm" or "spinning" */
  #report(text, kind = "") {
    if (!dialog.open) this.handlers.say(text);
    get("outcome").textContent = text;
    get("outcome").className = `quiet ${kind}`;
  }

  /** Reports a file that was written, with its folder. @param {string} done @param {string} file */
  #reportFile(done, file) {
    const [, folder, name] = file.match(/^(.*?)[\\/]?([^\\/]*)$/) ?? [];
    this.#report(`${done} as ${name}`);
    const place = make("span", { className: "quiet", textContent: folder });
    const copy = make("button", { textContent: "Copy path", onclick: () => this.#copy(file, copy, place) });
    const reveal = make("button", { textContent: "Show in folder", hidden: !this.clip?.reveal, onclick: () => this.#act(async () => void (await this.handlers.ask("reveal", { file }))) });
    get("outcome").append(place, make("span", { className: "chips" }, reveal, copy));
  }

  /** @param {string} path @param {HTMLElement} button @param {HTMLElement} place shows the selected path if the browser cannot copy */
  async #copy(path, button, place) {
    try {
      await navigator.clipboard.writeText(path);
      button.textContent = "Copied";
    } catch {
      place.textContent = path;
      getSelection()?.selectAllChildren(place);
    }
  }

  /** Runs an action on the tile and reports its outcome. @param {(tile: number) => Promise<void>} action @param {string} [doing] what it does, if it takes long */
  async #act(action, doing = "") {
    try {
      if (doing) this.#report(doing, "spinning");
      await action(await this.#tileNumber());
      this.#mark();
    } catch (error) {
      this.#report(/** @type {Error} */ (error).message, "alarm");
    }
  }

  async save() {
    const name = /** @type {HTMLInputElement} */ (get("name"));
    const button = get("save");
    if (!name.value.trim()) {
      this.#report("Type a name for the look first.", "alarm");
      return name.focus();
    }
    const overwrite = button.textContent === REPLACE;
    await this.#act(async (tile) => {
      try {
        const { file } = await this.handlers.ask("save", { tile, name: name.value.trim(), overwrite });
        button.textContent = SAVE;
        this.#reportFile("Saved", file);
      } catch (error) {
        if (/exists/.test(String(error))) button.textContent = REPLACE;
        throw error;
      }
    });
  }

  /** The name in the field, else a name derived from the style. */
  get name() {
    const given = /** @type {HTMLInputElement} */ (get("name")).value.trim();
    return given || (this.tile?.name ?? "style").replace(/[^A-Za-z0-9_-]+/g, "-");
  }

  /** Writes the style for other programs. @param {string} kind of a target */
  export(kind) {
    return this.#act(async (tile) => this.#reportFile("Exported", (await this.handlers.ask("export", { tile, name: this.name, kind })).file), `Exporting ${this.name}.${kind}…`);
  }

  async render() {
    const stem = (this.clip?.name ?? "film").replace(/\.\w+$/, "").replace(/[^A-Za-z0-9_-]+/g, "-").slice(0, 30);
    const clip = /** @type {Clip} */ (this.clip);
    this.rendering = true;
    this.#showRender(clip);
    this.progress({});
    const doing = `Rendering ${this.clip?.name ?? "the film"} in this look…`;
    await this.#act(async (tile) => this.#reportFile("Rendered", (await this.handlers.ask("render", { tile, name: `${stem}-${this.name}`.slice(0, 64) })).file), doing);
    this.rendering = false;
    this.#showRender(clip);
  }

  /** Shows whether a film can be rendered or is being rendered. @param {Clip} clip */
  #showRender(clip) {
    const button = /** @type {HTMLButtonElement} */ (get("render"));
    button.disabled = !clip.render || this.rendering;
    button.textContent = this.rendering ? "Rendering…" : clip.count > 1 ? "Render the whole film" : "Save the picture";
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
    this.dirty = true;
  }

  #listen() {
    get("close").onclick = () => dialog.close();
    dialog.addEventListener("close", () => get("rail").prepend(get("progress")));
    dialog.addEventListener("close", () => this.source.open({ .../** @type {Clip} */ (this.clip), frames: [] }, 180));
    get("like").onclick = () => this.like();
    get("keep").onclick = () => this.star();
    get("split").onclick = () => this.toggleSplit();
    get("play-large").onclick = () => this.#play(!this.source.playing);
    for (const [event, on] of Object.entries({ pointerdown: true, pointerup: false, pointerleave: false })) get("hold").addEventListener(event, () => this.hold(on));
    get("saving").addEventListener("submit", (event) => {
      event.preventDefault();
      this.save();
    });
    get("name").addEventListener("focus", () => /** @type {HTMLInputElement} */ (get("name")).select());
    get("name").addEventListener("input", () => (get("save").textContent = SAVE));
    get("render").onclick = () => this.render();
    get("cancel").onclick = () => this.handlers.ask("cancel");
    get("design").onclick = () => this.#act(async (tile) => void window.open((await this.handlers.ask("design", { tile })).url, "_blank", "noopener"));
    this.#listenToPointer();
    dialog.addEventListener("keydown", (event) => this.#key(event));
    dialog.addEventListener("keyup", (event) => event.key.toLowerCase() === SHARED_KEYS.original && this.hold(false));
    addEventListener("resize", () => (this.dirty = true));
  }

  #listenToPointer() {
    followPointer(pad, (event) => {
      const box = pad.getBoundingClientRect();
      this.#moveTo((event.clientX - box.left) / box.width, 1 - (event.clientY - box.top) / box.height);
    });
    this.divider.listen();
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const target = /** @type {HTMLElement} */ (event.target);
    if (event.ctrlKey || event.metaKey || event.altKey || target.matches("input")) return;
    const step = event.shiftKey ? 0.1 : 0.02;
    const [x, y] = this.at;
    const moves = { ArrowLeft: [x - step, y], ArrowRight: [x + step, y], ArrowUp: [x, y + step], ArrowDown: [x, y - step] };
    const move = target === pad && moves[/** @type {keyof typeof moves} */ (event.key)];
    if (move) this.#moveTo(move[0], move[1]);
    else if (event.key === "Enter" && !target.matches("button")) this.like();
    else if (event.key.toLowerCase() === SHARED_KEYS.save) this.star();
    else if (event.key === SHARED_KEYS.compare) this.toggleSplit();
    else if (event.key === SHARED_KEYS.original) this.hold(true);
    else if (event.key === SHARED_KEYS.play) this.#play(!this.source.playing);
    else return;
    event.preventDefault();
  }
}
