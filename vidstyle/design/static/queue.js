// The queue of films that are rendered, or wait for it.

import { get, make, title } from "./elements.js";

/**
 * @typedef {object} Job
 * @property {number} number
 * @property {"waiting" | "rendering" | "done" | "stopped" | "failed"} state
 * @property {number} done frames
 * @property {number | null} total frames
 * @property {string} text
 * @property {string} file
 * @property {string} folder
 * @property {string} style
 * @property {string} source
 * @property {string} address of the file, once it is there
 * @property {boolean} is_picture
 * @property {string} partial the file with the finished part of a stopped job; "" without one
 */

/** No time is estimated before this part is done: the first frames take longer. */
const MIN_ESTIMATED_RATIO = 0.03;
const STATES = { waiting: "Waiting", rendering: "Rendering", done: "Saved in", stopped: "Stopped", failed: "Failed" };

/** Lists the jobs; a button of the bar opens the list and tells how many are not finished. */
export class Queue {
  /** Whether a file can be shown in its folder. */
  reveals = false;
  /** Whether the button is shown even before a film was rendered, so that nothing moves when one is. */
  isKept = false;
  /** Whether to show the newest file once the list contains it. */
  #plays = false;

  none = make("p", { className: "quiet", textContent: "Films and pictures that you render are listed here." });

  /** @param {import("./session.js").Session} session */
  constructor(session) {
    this.session = session;
    this.panel = get("queue");
    this.button = get("to-queue");
    this.panel.append(this.none);
    this.panel.addEventListener("beforetoggle", () => this.#place());
    addEventListener("resize", () => this.#place());
    session.on("queue", (jobs) => this.#show(jobs));
  }

  /** Ends the list where its button ends. */
  #place() {
    const { right } = this.button.getBoundingClientRect();
    this.panel.style.setProperty("--right", `${right ? innerWidth - right : 0}px`);
  }

  /** Keeps the button in its place from now on. */
  keep() {
    this.isKept = true;
    this.button.hidden = false;
    this.button.classList.toggle("empty", !get("jobs").children.length);
  }

  /** Opens the list. */
  open() {
    if (!this.panel.matches(":popover-open")) this.panel.showPopover();
  }

  /** Opens the list, and goes to its first button: that plays the newest film once it is there. */
  enter() {
    if (this.button.hidden) return false;
    this.open();
    /** @type {HTMLElement | null} */ (get("jobs").querySelector("[data-action]"))?.focus();
  }

  /** Plays the newest film. */
  playNewest() {
    /** @type {HTMLElement | null} */ (get("jobs").querySelector("[data-action^=play]"))?.click();
  }

  /** Shows the file that was just finished, once the list has it. */
  play() {
    this.#plays = true;
  }

  /** @param {Job[]} jobs */
  #show(jobs) {
    const left = jobs.filter(({ state }) => state === "waiting" || state === "rendering");
    this.button.hidden = !jobs.length && !this.isKept;
    this.button.classList.toggle("empty", !jobs.length);
    this.none.hidden = jobs.length > 0;
    get("queue-count").textContent = left.length ? String(left.length) : "";
    this.button.setAttribute("aria-label", left.length ? `Renders, ${left.length} not finished` : "Renders");
    const focused = /** @type {HTMLElement | null} */ (document.activeElement)?.dataset.action;
    get("jobs").replaceChildren(...[...jobs].reverse().map((job) => this.#row(job)));
    if (focused) this.#focus(focused);
    const newest = /** @type {HTMLElement | null} */ (get("jobs").querySelector("[data-action^=play]"));
    if (!newest) return;
    newest.classList.add("strong");
    if (this.#plays) newest.click();
    this.#plays = false;
  }

  /** Focuses a button of the list, which may have been made again. @param {string} action */
  #focus(action) {
    const play = action.replace("stop", "play"); // takes the place of "Stop" at the end
    for (const name of [play, action]) /** @type {HTMLElement | null} */ (document.querySelector(`[data-action="${name}"]`))?.focus();
  }

  /** @param {Job} job */
  #row(job) {
    const { number, state, done, total, text, file, folder, style, source, address, partial, is_picture: isPicture } = job;
    const isOver = state !== "waiting" && state !== "rendering";
    const part = total ? `${Math.floor((100 * done) / total)} %` : "";
    const pace = isPicture || !done ? "" : [part, done > MIN_ESTIMATED_RATIO * (total ?? 0) && text.split(", ").find((each) => each.endsWith("left"))].filter(Boolean).join(", ");
    const facts = { waiting: "", rendering: pace, done: folder, stopped: partial && `at ${part}; ${partial} keeps the finished part`, failed: text }[state];
    const bar = make("progress", { ariaLabel: `Progress of ${file}` });
    if (total && done) [bar.max, bar.value] = [total, done];
    const buttons = make("div", { className: "row" });
    if (!isOver) buttons.append(this.#button(`stop-${number}`, state === "waiting" ? "Remove" : "Stop", () => this.session.ask("stop", { job: number })));
    if (partial) buttons.append(this.#button(`continue-${number}`, "Continue", () => this.session.ask("resume", { job: number })));
    if (state === "stopped" || state === "failed") buttons.append(this.#button(`remove-${number}`, partial ? "Remove both" : "Remove", () => this.session.ask("discard", { job: number })));
    if (address) {
      const action = `play-${number}`;
      buttons.append(this.#button(action, isPicture ? "Show" : "Play", () => this.#play(file, address, isPicture, action)));
      if (this.reveals) buttons.append(this.#button(`reveal-${number}`, "Show in folder", () => this.session.ask("reveal", { job: number })));
      else buttons.append(make("a", { className: "button", href: address, download: file, textContent: "Download" }));
    }
    return make("li", {}, make("b", { textContent: file }), make("span", { className: "quiet", textContent: `${source}, ${title(style)}` }),
      make("span", { className: state === "failed" ? "failed" : "quiet", textContent: `${state === "rendering" && !facts ? "Rendering…" : STATES[state]} ${facts}`.trim() }),
      ...(state === "rendering" ? [bar] : []), buttons);
  }

  /** Shows a rendered film or picture on this page. @param {string} file @param {string} address @param {boolean} isPicture @param {string} action of the button that takes the focus back */
  #play(file, address, isPicture, action) {
    const player = /** @type {HTMLDialogElement} */ (get("player"));
    const shown = isPicture ? make("img", { src: address, alt: file }) : make("video", { src: address, controls: true, autoplay: true, loop: true });
    shown.onerror = () => get("player-note").textContent = "This file cannot be shown: it was removed, or this browser does not know its type.";
    get("player-name").textContent = file;
    get("player-note").textContent = "";
    get("player-place").replaceChildren(shown);
    player.onclose = () => {
      get("player-place").replaceChildren();
      this.open();
      this.#focus(action);
    };
    player.showModal();
  }

  /** @param {string} action @param {string} label @param {() => void} onclick */
  #button(action, label, onclick) {
    const button = make("button", { type: "button", textContent: label, onclick });
    button.dataset.action = action;
    return button;
  }
}
