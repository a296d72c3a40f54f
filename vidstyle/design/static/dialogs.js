// The dialogs for saving, exporting and rendering.

import { get, make, title } from "./elements.js";

/** @typedef {import("./session.js").Session} Session */

/**
 * Progress of a long job, as the server reports it.
 * @typedef {object} Progress
 * @property {"render" | "steady" | "export"} kind
 * @property {number} done
 * @property {number} total
 * @property {string} [text]
 * @property {string} [file]
 * @property {string} [error]
 * @property {boolean} finished
 */

/** Opens a dialog and resolves to the value of the button that closes it. @param {string} id @returns {Promise<string>} */
export function openDialog(id) {
  const dialog = /** @type {HTMLDialogElement} */ (get(id));
  dialog.returnValue = "";
  dialog.showModal();
  const [name] = dialog.querySelectorAll("input[type=text]");
  /** @type {HTMLInputElement | undefined} */ (name)?.select();
  return new Promise((done) => dialog.addEventListener("close", () => done(dialog.returnValue), { once: true }));
}

/** The name of a style until it gets one. */
const NEW_NAME = "new";

/** Matches the error for a file that already exists. */
const EXISTS_ERROR = /exists/;

/** Asks whether to replace a file; resolves to "replace" if so. @param {string} message */
function askToReplace(message) {
  get("replace-text").textContent = message;
  return openDialog("replace-dialog");
}

/** The dialogs that write files. */
export class Dialogs {
  /** The ending of rendered files. */
  #suffix = ".mp4";

  /** Begins the names of rendered files. */
  #stem = "film";
  /** The styles that every command knows by name. @type {Set<string>} */
  #named = new Set();
  /** Is called once a picture is saved. */
  onpicture = () => {};
  /** Is called to play the film that was saved last. */
  onplay = () => {};

  /** @param {Session} session @param {(text: string, alarm?: boolean, visible?: boolean) => void} say */
  constructor(session, say) {
    this.session = session;
    this.say = say;
    session.on("clip", (clip) => this.#fit(clip));
    session.on("styles", (/** @type {import("./types.js").StyleInfo[]} */ styles) => (this.#named = new Set(styles.filter(({ has_name: hasName }) => hasName).map((each) => each.name))));
    this.#text("save-name").addEventListener("input", () => this.#checkName());
    session.on("targets", (targets) => this.#fill(targets));
    session.on("progress", (progress) => this.#progress(progress));
    get("render-stop").addEventListener("click", () => session.ask("cancel"));
    get("render-again").addEventListener("click", () => this.#start(true));
    get("render-dialog").addEventListener("submit", (event) => {
      event.preventDefault();
      this.#start(false);
    });
    get("copy").addEventListener("click", () => this.copy());
    for (const button of document.querySelectorAll("dialog [value=cancel]"))
      button.addEventListener("click", () => /** @type {Element & {close: (value: string) => void}} */ (button.closest("dialog")).close(""));
  }

  /** @param {string} id */
  #text(id) {
    return /** @type {HTMLInputElement} */ (get(id));
  }

  /** Saves the style to its file, or asks for a name if it has none. */
  async save() {
    if (!this.session.state?.file) return this.saveAs();
    const answer = await this.session.ask("save");
    if (answer) this.say(`Saved as ${answer.file}.`);
  }

  /** Refuses the names of other styles, since a name loads the first style that has it. */
  #checkName() {
    const input = this.#text("save-name"), wanted = input.value.trim();
    const isTaken = this.#named.has(wanted) && this.session.state?.file !== `${wanted}.toml`;
    input.setCustomValidity(isTaken ? "Another style already has this name. Choose a different one." : "");
  }

  async saveAs() {
    const { name: own = "", file = "" } = this.session.state ?? {}, isShipped = !file && this.#named.has(own);
    this.#text("save-name").value = isShipped ? `My ${own}` : own === NEW_NAME ? "" : own;
    get("save-note").textContent = `${isShipped ? `${title(own)} comes with vidstyle and is never changed. Your version gets a different name.` : "The style is saved as a file with this name."} To save the ${this.#suffix === ".png" ? "picture, press Save picture" : "film, press Render film"}.`;
    this.#checkName();
    if ((await openDialog("save-dialog")) !== "save") return;
    const name = this.#text("save-name").value.trim();
    const answer = await this.#write("save_as", { name });
    if (answer) this.say(`Saved as ${answer.file}.`);
  }

  /**
   * Writes a file; asks before replacing an existing one.
   * @param {string} kind
   * @param {object} fields
   */
  async #write(kind, fields) {
    try {
      return await this.session.attempt(kind, { ...fields, overwrite: false });
    } catch (error) {
      const { message } = /** @type {Error} */ (error);
      if (!EXISTS_ERROR.test(message)) this.session.onerror(message);
      else if ((await askToReplace(message)) === "replace") return this.session.ask(kind, { ...fields, overwrite: true });
      return null;
    }
  }

  /** Lists the export targets. @param {{kind: string, title: string, use: string, help: string}[]} targets */
  #fill(targets) {
    get("targets").replaceChildren(...targets.map(({ kind, title: name, use, help }, number) => {
      const about = make("span", {}, make("b", { textContent: name }), make("span", { textContent: `${use}.` }), make("span", { className: "help", textContent: `A .${kind} file: ${help}` }));
      return make("label", { className: "radio" }, make("input", { type: "radio", name: "kind", value: kind, checked: !number }), about);
    }));
  }

  async export() {
    this.#text("export-name").value = this.session.state?.name ?? "";
    if ((await openDialog("export-dialog")) !== "export") return;
    const kind = /** @type {HTMLInputElement} */ (document.querySelector("input[name=kind]:checked")).value;
    const answer = await this.#write("export", { kind, name: this.#text("export-name").value.trim() });
    if (answer) this.say(`Exported as ${answer.file}.`);
  }

  /** Fits the dialog to a film or a photograph. @param {import("./player.js").Clip} clip */
  #fit({ name, count }) {
    const isFilm = count !== 1;
    this.#suffix = isFilm ? ".mp4" : ".png";
    this.#stem = name.replace(/^.*[\\/]|\.[^.\\/]*$/g, "").replace(/[^\p{L}\p{N}_-]+/gu, "-").replace(/^-|-$/g, "") || "film";
    get("render").replaceChildren(isFilm ? "Render" : "Save", make("span", { textContent: isFilm ? "film" : "picture" }));
    get("render-title").textContent = isFilm ? "Render this film" : "Save this picture";
    get("render-go").textContent = isFilm ? "Render" : "Save";
    for (const element of document.querySelectorAll(".of-film")) element.toggleAttribute("hidden", !isFilm);
  }

  render() {
    this.#text("render-name").value = `${this.#stem}-${this.session.state?.name ?? "style"}${this.#suffix}`;
    get("render-state").textContent = "";
    this.#running(false);
    return openDialog("render-dialog");
  }

  /** The file and the number of frames to render. */
  get #job() {
    return { name: this.#text("render-name").value.trim(), frames: Number(this.#text("render-frames").value) || null };
  }

  /** @param {boolean} overwrite */
  async #start(overwrite) {
    get("render-again").hidden = true;
    this.#running(true);
    get("render-state").textContent = "";
    try {
      await this.session.attempt("render", { ...this.#job, overwrite });
    } catch (error) {
      this.#failed(/** @type {Error} */ (error).message);
    }
  }

  /** @param {string} text */
  #failed(text) {
    this.#running(false);
    get("render-state").textContent = text;
    get("render-again").hidden = !EXISTS_ERROR.test(text);
  }

  /** @param {boolean} running */
  #running(running) {
    get("render-go").hidden = running;
    get("render-stop").hidden = !running;
    get("render-again").hidden = true;
    const bar = /** @type {HTMLProgressElement} */ (get("render-bar"));
    bar.hidden = !running;
    bar.removeAttribute("value");
  }

  /** @param {Progress} progress */
  #progress({ kind, done, total, text, file, error, finished }) {
    if (kind !== "render") {
      if (error || (finished && file)) this.say(error ?? `Saved as ${file}.`);
      return;
    }
    if (error) return this.#failed(error);
    const bar = /** @type {HTMLProgressElement} */ (get("render-bar"));
    if (total) [bar.max, bar.value] = [total, done];
    const isPicture = this.#suffix === ".png";
    if (isPicture && !finished) return;
    get("render-state").textContent = finished ? text || `Saved as ${file}.` : text ?? (total ? `Frame ${done} of ${total}` : `Frame ${done}`);
    if (!finished) return;
    this.#running(false);
    if (isPicture && file) {
      /** @type {HTMLDialogElement} */ (get("render-dialog")).close("");
      this.onpicture();
    }
    // Where the queue or the dialog shows the end already, it is only announced.
    const isSeen = Boolean(document.querySelector("#queue:popover-open, #render-dialog[open]"));
    this.say(text || `Saved as ${file}.`, false, !isSeen);
    if (!isSeen && !isPicture) get("toast").append(make("button", { type: "button", textContent: "Play", onclick: () => this.onplay() }));
  }

  /** Copies the equivalent command line. */
  async copy() {
    const answer = await this.session.ask("command", this.#job);
    if (!answer) return;
    try {
      await navigator.clipboard.writeText(answer.text);
      this.say("Command copied.");
    } catch {
      this.say(answer.text);
    }
  }

  help() {
    return openDialog("help-dialog");
  }
}
