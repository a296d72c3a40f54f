// Opening a film, a photograph or a style file: by the picker, or dropped on the page.

import { get } from "./elements.js";

/** The server accepts no larger files. */
const MAX_UPLOAD_BYTES = 2 ** 31;

/** Uploads files to the server. */
export class FilePicker {
  /**
   * @param {import("./session.js").Session} session
   * @param {object} handlers
   * @param {() => void} handlers.onstyle is called before a style file is opened
   * @param {() => void} handlers.onopened is called when a style file is open
   */
  constructor(session, handlers) {
    this.session = session;
    this.handlers = handlers;
    const picker = /** @type {HTMLInputElement} */ (get("file"));
    for (const button of document.querySelectorAll(".choose-file")) button.addEventListener("click", () => picker.click());
    picker.addEventListener("change", () => {
      if (picker.files?.[0]) this.#take(picker.files[0]);
      picker.value = "";
    });
    for (const kind of ["dragover", "dragleave", "drop"])
      addEventListener(kind, (event) => this.#drag(/** @type {DragEvent} */ (event)));
  }

  /** @param {DragEvent} event */
  #drag(event) {
    if (!event.dataTransfer?.types.includes("Files")) return;
    event.preventDefault();
    document.body.classList.toggle("over", event.type === "dragover");
    const file = event.type === "drop" && event.dataTransfer.files[0];
    if (file) this.#take(file);
  }

  /** Shows an error below the button that opens files, or on the open style; "" hides the one before. @param {string} text */
  #report(text) {
    const line = get("open-error"), isSeen = line.parentElement?.checkVisibility();
    line.textContent = text;
    line.hidden = !text;
    if (text && !isSeen) this.session.onerror(text);
  }

  /** Uploads a style file, a film or a photograph. @param {File} file */
  async #take(file) {
    this.#report("");
    if (!file.size) return this.#report(`${file.name}: the file is empty.`);
    if (file.size > MAX_UPLOAD_BYTES) return this.#report(`${file.name}: too large to upload; name it on the command line: vidstyle design FILE.`);
    const isStyle = /\.toml$/i.test(file.name);
    if (isStyle) this.handlers.onstyle();
    const bar = /** @type {HTMLProgressElement} */ (get("uploading"));
    const shown = ["source-name", "source-facts", "drop-here"].map((id) => get(id)), before = shown.map((each) => each.textContent);
    /** @param {(string | null)[]} texts */
    const say = (texts) => shown.forEach((each, place) => (each.textContent = texts[place]));
    bar.hidden = false;
    if (!isStyle) say([file.name, "opening…", `Opening ${file.name}…`]);
    try {
      await this.session.connection.upload(file, (part) => (bar.value = part));
      if (isStyle) this.handlers.onopened();
    } catch (error) {
      this.#report(/** @type {Error} */ (error).message);
      say(before);
    }
    bar.hidden = true;
  }
}
