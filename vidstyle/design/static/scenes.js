// Styles over time: the cues of the film, which the picture shows while they are open.

import { CueEditor } from "./cue_editor.js";
import { download, get, press, title } from "./elements.js";
import { showPlayhead } from "./timeline.js";

/** Edits cues, and has the server show them. */
export class Scenes {
  /** @type {CueEditor | null} */
  #editor = null;
  #isAsking = false;

  /**
   * @param {import("./session.js").Session} session
   * @param {import("./preview.js").Preview} preview
   * @param {object} handlers
   * @param {(text: string) => void} handlers.say
   * @param {(isOpen: boolean) => void} handlers.onopen is called when they are opened or closed
   * @param {() => void} handlers.onchange is called after a change of the cues
   * @param {(style: string) => string} handlers.pictureOf returns the address of the film's picture in a style, or ""
   */
  constructor(session, preview, { say, onopen, onchange, pictureOf }) {
    this.session = session;
    this.preview = preview;
    this.say = say;
    this.onopen = onopen;
    this.onchange = onchange;
    this.pictureOf = pictureOf;
    get("to-scenes").addEventListener("click", () => this.toggle());
    get("save-cues").addEventListener("click", () => this.save());
    session.on("clip", () => this.#close());
    session.on("connection", (loss) => !loss && this.isOpen && this.#send());
  }

  get isOpen() {
    return this.#editor !== null;
  }

  /** Opens the scenes of the film, or closes them. */
  async toggle() {
    if (this.isOpen) return this.#close();
    if (!this.preview.player.isFilm || this.#isAsking) return;
    this.#isAsking = true;
    this.say("Finding the scenes of the film…");
    const answer = await this.session.ask("scenes");
    this.#isAsking = false;
    if (!answer) return;
    this.say("");
    get("scenes").hidden = false;
    const kept = sessionStorage.getItem(this.#place) ?? "";
    this.#editor = new CueEditor(answer.sheet, {
      onchange: () => this.#send(),
      seek: (time) => this.preview.player.show(Math.ceil(time * this.preview.player.clip.fps - 0.001)),
    }, kept);
    this.showLooks();
    press(get("to-scenes"), true);
    this.onopen(true);
    this.follow();
    if (kept) this.#send();
  }

  /** Shows styles on the user's film, as far as there are pictures. */
  showLooks() {
    if (!this.#editor) return;
    for (const style of Object.keys(this.#editor.sheet.styles)) {
      const picture = this.pictureOf(style);
      if (picture) this.#editor.showLook(style, picture);
    }
  }

  /** Where the cues of this film are kept in case the page is loaded again. */
  get #place() {
    const { name, count } = this.preview.player.clip;
    return `cues of ${name}, ${count}`;
  }

  #close() {
    if (!this.isOpen) return;
    this.#editor = null;
    get("scenes").hidden = true;
    press(get("to-scenes"), false);
    this.onopen(false);
    this.session.ask("cues", { text: "" });
  }

  /** Shows the cues in the picture, or says what is wrong with them. */
  async #send() {
    const editor = /** @type {CueEditor} */ (this.#editor);
    this.onchange();
    sessionStorage.setItem(this.#place, editor.state);
    const text = editor.mistake ? "" : editor.text;
    get("cue-answer").textContent = editor.mistake;
    await this.session.ask("cues", { text });
  }

  /** Whether there is a change of the cues to undo, or to make again. @param {"undo" | "redo"} which */
  has(which) {
    return Boolean(this.#editor?.has(which === "undo" ? -1 : 1));
  }

  /** Undoes a change of the cues, or makes it again. @param {"undo" | "redo"} which */
  again(which) {
    this.#editor?.undo(which === "undo" ? -1 : 1);
  }

  /** Moves the mark of the position. */
  follow() {
    const { clip, number } = this.preview.player;
    if (this.isOpen) showPlayhead(get("timeline"), number / Math.max(1, clip.count));
  }

  /** Downloads the cue file. */
  save() {
    const editor = /** @type {CueEditor} */ (this.#editor), { sheet } = editor;
    if (!editor.mistake) download(new Blob([editor.text], { type: "application/toml" }), sheet.file);
    const used = editor.cues.some(({ style }) => style === this.session.state?.name) && this.session.state?.dirty;
    get("cue-answer").textContent = editor.mistake || `Saved as ${sheet.file} in your downloads${used ? `. Save the look ${title(String(this.session.state?.name))} too` : ""}. On the command line: vidstyle render FILM OUTPUT --cues ${sheet.file}`;
  }
}
