// A page of many styles: their pictures of one source, and the large picture of one style.

import { announce } from "./announce.js";
import { download, get, make, press } from "./elements.js";
import { missing, Runner } from "./runner.js";
import { addressedStyle } from "./shared_link.js";
import { loadPicture } from "./source.js";
import { load, loadStyleData } from "./store.js";
import { Tiles } from "./tiles.js";
import { Viewer } from "./viewer.js";

/** @typedef {{name: string, title: string}} Example a picture that comes with the page */
/** @type {{styles: import("./tiles.js").Listed[], unlisted: import("./tiles.js").Listed[], pictures: Example[]}} */
const index = JSON.parse(get("data").textContent ?? "");
const dialog = /** @type {HTMLDialogElement} */ (get("viewer"));

/** @param {string} text @param {number} [seconds] */
const say = (text, seconds = 0) => announce(get("progress"), text, { seconds });

/** @typedef {import("./store.js").StyleFile} StyleFile */

/** Returns the value of a control as a style file has it. @param {any} value */
const written = (value) => (typeof value === "string" ? JSON.stringify(value) : String(value));

/** Returns the style file with changed values. @param {StyleFile} file @param {Record<string, any>} changes by path */
function styleFile({ text, places }, changes) {
  const rows = text.split("\n");
  for (const [path, value] of Object.entries(changes)) {
    const [number, isThere] = places[path];
    const row = `${path.split(".").at(-1)} = ${written(value)}`;
    rows[number] = isThere ? row : `${rows[number]}\n${row}`;
  }
  return rows.join("\n");
}

/** Returns the command that makes the same from a film. @param {string} name @param {Record<string, any>} changes by path */
function command(name, changes) {
  const options = Object.entries(changes).map(([path, value]) => ` --set '${path}=${value}'`);
  return `vidstyle render in.mp4 out.mp4 --style ${name}${options.join("")}`;
}

class Showcase {
  /** @type {Viewer | null} null: this browser cannot run styles */
  viewer = null;
  /** @type {Tiles | null} */
  tiles = null;
  /** The example that is shown; null: the user's own source. @type {Example | null} */
  #example = null;
  /** @type {import("./store.js").ShowcaseStyle | null} */
  #style = null;

  async start() {
    const lacks = missing();
    const runner = lacks.length ? null : new Runner({ onrestored: () => this.#redraw() });
    if (runner) this.viewer = new Viewer(runner);
    const source = this.viewer?.source;
    if (!source) {
      for (const id of ["open-file", "use-camera"]) /** @type {HTMLButtonElement} */ (get(id)).disabled = true;
      say(`Only the examples can be shown: ${lacks.join("; ")}.`);
    }
    this.tiles = new Tiles(index.styles, source ?? /** @type {any} */ ({ picture: null, video: null }), (done, count) =>
      say(done < count ? `${done} of ${count} looks` : "", 0),
    );
    this.tiles.runner = runner;
    document.body.classList.toggle("embedded", new URLSearchParams(location.search).has("embed"));
    this.#addExamples();
    await this.#showExample(index.pictures[0]);
    this.#listen();
    await this.#follow();
  }

  #redraw() {
    this.viewer?.redraw();
    if (!this.#example) this.tiles?.restart();
  }

  #addExamples() {
    for (const example of index.pictures) {
      const image = make("img", { src: `pictures/${example.name}.webp`, alt: "" });
      const button = make("button", { title: example.title }, image, make("span", { textContent: example.title }));
      button.onclick = () => this.#showExample(example);
      get("examples").append(button);
    }
  }

  /** @param {Example} example */
  async #showExample(example) {
    this.#example = example;
    this.#markExample();
    this.tiles?.showImages((name) => `pictures/${example.name}/${encodeURIComponent(name)}.webp`);
    if (dialog.open) await this.#openExample();
  }

  #markExample() {
    [...get("examples").children].forEach((button, number) => press(button, index.pictures[number] === this.#example));
  }

  /** Opens the example in full size, if it is not open. */
  async #openExample() {
    const example = this.#example;
    if (!example || !this.viewer) return;
    const picture = await loadPicture(await load(`pictures/${example.name}`));
    if (this.#example !== example) return;
    this.viewer.source.show(picture);
    this.#example = example;
    this.#markExample();
  }

  #listen() {
    if (this.viewer) {
      const { source } = this.viewer;
      const shown = source.onopen;
      source.onopen = () => {
        shown();
        this.#opened();
      };
      this.viewer.onchange = () => this.#showCommand();
      get("open-file").onclick = () => get("file").click();
      get("use-camera").onclick = () => source.openCamera();
    }
    get("close").onclick = () => dialog.close();
    dialog.addEventListener("close", () => {
      if (location.hash) history.pushState(null, "", location.pathname + location.search);
      this.#resume();
    });
    get("copy").onclick = () => this.#copy();
    get("style-file").onclick = () => this.#saveStyleFile();
    addEventListener("hashchange", () => this.#follow());
  }

  /** A picture was opened in the viewer: the user's own, unless an example is opened. */
  #opened() {
    const { picture } = /** @type {Viewer} */ (this.viewer).source;
    if (picture instanceof HTMLImageElement && picture.src.startsWith("data:")) return;
    this.#example = null;
    this.#markExample();
    this.tiles?.restart();
  }

  #resume() {
    if (!this.tiles) return;
    this.tiles.isPaused = false;
    this.tiles.resume();
  }

  async #follow() {
    await this.#route().catch((error) => (this.viewer?.say(error.message, 0), say(error.message)));
  }

  /** Shows the style that the address names, or the list. */
  async #route() {
    const name = addressedStyle();
    const listed = [...index.styles, ...index.unlisted].find((style) => style.name === name);
    if (!listed) return dialog.close();
    if (!this.viewer) return say("This browser cannot run styles.");
    if (this.tiles) this.tiles.isPaused = true;
    if (!dialog.open) dialog.showModal();
    for (const heading of dialog.querySelectorAll("h1, h2")) heading.textContent = name;
    get("note").textContent = listed.note;
    this.viewer.say("Preparing this look.", 0);
    const [style] = await Promise.all([loadStyleData(name), this.#openExample()]);
    this.#style = style;
    await this.viewer.show(style);
    this.viewer.say("");
    this.#showCommand();
  }

  get #changes() {
    return this.viewer?.panel?.changes ?? {};
  }

  #showCommand() {
    if (this.#style) get("command").textContent = command(this.#style.name, this.#changes);
  }

  async #copy() {
    this.#showCommand();
    await navigator.clipboard.writeText(get("command").textContent ?? "").then(
      () => this.viewer?.say("Copied."),
      () => getSelection()?.selectAllChildren(get("command")),
    );
  }

  #saveStyleFile() {
    if (!this.#style) return;
    const { name, file } = this.#style;
    download(new Blob([styleFile(file, this.#changes)], { type: "application/toml" }), `${name.replace(":", "-")}.toml`);
  }
}

new Showcase().start().catch((error) => say(error.message));
