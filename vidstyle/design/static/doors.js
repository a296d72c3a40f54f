// The ways from the front page to the other pages, which are made from the open film.

import { get, icon, make } from "./elements.js";

/** The other pages: icon, name, purpose. @type {Record<string, [string, string, string]>} */
const OTHER_PAGES = {
  explore: ["styles", "Explore new looks", "Choose from random styles on your own picture"],
  sheet: ["star", "Sheet of all looks", "Your picture in every look, as a page to keep or send"],
  comic: ["panels", "Make comic pages", "The key frames of your film, to read in the browser"],
  print: ["print", "Comic pages as PDF", "The same pages, to print"],
  live: ["camera", "Live camera", "Restyle a webcam while you watch"],
};

/** The pages that the front page makes from a file, and their progress messages. @type {Record<string, string>} */
const MADE = { sheet: "Drawing all looks…", comic: "Choosing key frames and drawing pages…", print: "Drawing pages for print…" };
/** Those that need a film: a photograph has no key frames. */
const OF_FILMS = ["comic", "print"];

/** The sources of the live page without a camera. */
const WITHOUT_CAMERA = { "live-film": "Use this film", "live-test": "Use a test picture" };

/** Opens other pages. */
export class Doors {
  #isFilm = false;
  /** Whether the film is the example, which nobody has opened. */
  #isExample = false;
  /** The tabs that wait for documents, by kind. @type {Map<string, Window>} */
  #tabs = new Map();

  /** @param {import("./session.js").Session} session @param {() => void} onmissing is called when a page needs a film, but no film is open */
  constructor(session, onmissing) {
    this.session = session;
    this.onmissing = onmissing;
    this.root = get("other-pages");
    session.on("making", ({ kind, text }) => this.#report(kind, text));
  }

  /** Offers pages. @param {string[]} kinds */
  offer(kinds) {
    const doors = kinds.filter((kind) => kind in OTHER_PAGES).map((kind) => this.#door(kind));
    this.root.replaceChildren(...doors);
    this.root.hidden = !doors.length;
    this.#show();
  }

  /** @param {boolean} isFilm @param {boolean} isExample */
  take(isFilm, isExample) {
    [this.#isFilm, this.#isExample] = [isFilm, isExample];
    this.#show();
  }

  /** Offers comics of films only. */
  #show() {
    for (const door of /** @type {NodeListOf<HTMLElement>} */ (this.root.querySelectorAll("[data-kind]")))
      door.hidden = OF_FILMS.includes(String(door.dataset.kind)) && !this.#isFilm;
  }

  /** Returns the button that opens another page. @param {string} kind */
  #door(kind) {
    const [image, name, purpose] = OTHER_PAGES[kind];
    const said = make("span", { className: "quiet", role: "status", textContent: purpose });
    const button = make("button", { type: "button" }, icon(image), make("span", {}, make("b", { textContent: name }), said));
    button.dataset.kind = kind;
    button.addEventListener("click", async () => {
      if (!this.#mayMake(kind)) return;
      if (button.nextElementSibling?.matches("a")) button.nextElementSibling.remove();
      button.disabled = true;
      said.textContent = MADE[kind] ?? "Starting…";
      const cancel = make("button", { type: "button", textContent: "Cancel", onclick: () => this.session.ask("cancel_page") });
      if (kind in MADE) button.after(cancel);
      const address = await this.#open(kind);
      if (!address && kind === "live") this.#offerWithoutCamera();
      if (address && kind in MADE) button.after(make("a", { href: address, target: "_blank", textContent: "Open the last one again" }));
      cancel.remove();
      said.textContent = purpose;
      button.disabled = false;
    });
    return button;
  }

  /** Shows how far a document is, on its button and in the tab that waits for it. @param {string} kind @param {string} text */
  #report(kind, text) {
    const said = this.root.querySelector(`[data-kind="${kind}"] [role=status]`);
    if (said) said.textContent = text;
    const tab = this.#tabs.get(kind);
    if (tab && !tab.closed) tab.document.body.textContent = `${text}. The page appears here.`;
  }

  /** Asks for a file before a page that needs one. @param {string} kind */
  #mayMake(kind) {
    if (!(kind in MADE) || !this.#isExample) return true;
    this.session.onerror(OF_FILMS.includes(kind) ? "Open a film first: a comic shows its key frames." : "Open a film or photograph first.");
    this.onmissing();
    return false;
  }

  /** Offers other sources for the live page. */
  #offerWithoutCamera() {
    const offered = Object.entries(WITHOUT_CAMERA).filter(([kind]) => kind === "live-test" || (this.#isFilm && !this.#isExample));
    const buttons = offered.map(([kind, textContent]) => make("button", { type: "button", textContent, onclick: () => this.#open(kind) }));
    document.querySelector(".no-camera")?.remove();
    this.root.append(make("div", { className: "no-camera" }, make("p", { textContent: "Without a camera, show the live page with:" }), ...buttons));
    buttons[0].focus();
  }

  /** Opens another page in a new tab; resolves to its address, "" if it did not open. @param {string} kind @returns {Promise<string>} */
  async #open(kind) {
    // A tab that is opened only after the answer would be blocked.
    const tab = kind === "print" ? null : open("", "_blank");
    if (tab && kind in MADE) {
      tab.document.title = OTHER_PAGES[kind][1];
      tab.document.body.textContent = `${MADE[kind]} The page appears here.`;
      this.#tabs.set(kind, tab);
    }
    const answer = await this.session.ask("page", { kind });
    this.#tabs.delete(kind);
    if (answer?.url && tab) tab.location = answer.url;
    else tab?.close();
    return answer?.url ?? "";
  }
}
