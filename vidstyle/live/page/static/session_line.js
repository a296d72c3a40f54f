// How a live session goes, in words and figures.

import { get, make } from "./elements.js";

/** @typedef {import("./page.js").Status} Status */

const RATE_MS = 5000;
/** The rate is measured over at least so many frames. */
const MIN_RATE_FRAMES = 4;
/** After so many times the usual interval without a frame, the page waits for one; at least this time. */
const [MAX_INTERVALS, MIN_WAIT_MS] = [4, 5000];
/** The displayed rate stays for this time, and until the measured one differs by this part of it. */
const MIN_RATE_SHOWN_MS = 5000;
const MIN_RATE_CHANGE = 0.3;
/** Frames per second from which movement is seen as such. */
const MIN_SMOOTH_RATE = 5;

/** Returns how many captured frames are shown, in words; "" if almost all are. @param {Status} now */
function shareOf({ frames, dropped }) {
  const part = frames / Math.max(1, frames + dropped);
  return part > 0.98 ? "" : `, ${Math.round(100 * part)} % of those captured`;
}

/** A lower rate is said in seconds, at least two of them. */
const MIN_ONE_RATE = 2 / 3;

/** @param {number} shown frames per second */
function inWords(shown) {
  if (shown >= 1.5) return `${Math.round(shown)} frames per second`;
  return shown > MIN_ONE_RATE ? "1 frame per second" : `a frame every ${shown > 0 ? Math.round(1 / shown) : "few"} seconds`;
}

/** Shows how the session goes in the elements `figures`, `sentence` and `line`. */
export class SessionLine {
  /** When the last frames were shown. @type {number[]} */
  #times = [];
  #displayedRate = 0;
  /** When it was last changed. */
  #changed = 0;

  /** A frame is shown. */
  count() {
    this.#times.push(performance.now());
  }

  /** The number of frames shown per second; 0 before the second one. */
  get #rate() {
    const now = performance.now(), times = this.#times;
    while (times.length > MIN_RATE_FRAMES && times[0] < now - RATE_MS) times.shift();
    return times.length > 1 ? (1000 * (times.length - 1)) / (times[times.length - 1] - times[0]) : 0;
  }

  /** The number of frames shown per second, which does not change all the time. */
  get #steadyRate() {
    const measured = this.#rate, now = performance.now();
    const isDue = !this.#displayedRate || now - this.#changed > MIN_RATE_SHOWN_MS;
    if (isDue && Math.abs(measured - this.#displayedRate) > MIN_RATE_CHANGE * this.#displayedRate) [this.#displayedRate, this.#changed] = [measured, now];
    return this.#displayedRate;
  }

  /** Whether the next frame is late, compared with those before. */
  get #isLate() {
    const usual = this.#rate ? 1000 / this.#rate : 0;
    return performance.now() - this.#times[this.#times.length - 1] > Math.max(MIN_WAIT_MS, MAX_INTERVALS * usual);
  }

  /** @param {Status} now @param {string} next the name of the style that is being prepared, in words; "": none */
  #sentence(now, next) {
    if (now.source_state === "ended") return "Ended";
    const shown = this.#steadyRate;
    if (next) return `Preparing ${next}; the picture may stand still`;
    if (!this.#times.length) return "Starting…";
    if (this.#isLate) return "Waiting for the next picture";
    if (!shown) return "Live";
    return `Live, ${this.#isSlow ? "only " : ""}${inWords(shown)}`;
  }

  /** Whether the frames shown are too few for movement. */
  get #isSlow() {
    return this.#steadyRate > 0 && this.#steadyRate < MIN_SMOOTH_RATE;
  }

  /** @param {Status} now @returns {string[][]} names, values and explanations */
  #facts(now) {
    return [
      ["Size", now.size.join(" × "), "width and height of the picture"],
      ["Shown here", inWords(this.#steadyRate) + shareOf(now), `restyled: ${now.rate.toFixed(1)} per second; ${now.dropped} of ${now.frames + now.dropped} captured frames were left out to stay live`],
      ["Delay", `${now.shown_ms.toFixed(0)} ms`, "median latency from capture to this page"],
      ["Detail", now.degraded, "a smaller picture is restyled and enlarged, to keep the frame rate"],
      ...now.targets.filter(([name]) => name !== "page").map(([name, text]) => [name, text, "another target"]),
    ];
  }

  /** @param {Status} now @param {string} next the name of the style that is being prepared, in words; "": none @param {boolean} isConnected */
  show(now, next, isConnected) {
    get("sentence").textContent = this.#sentence(now, next);
    get("figures").classList.toggle("running", now.source_state === "running" && isConnected);
    get("figures").classList.toggle("slow", Boolean(next) || this.#isLate || this.#isSlow);
    const facts = this.#facts(now).filter(([, text]) => text);
    get("line").replaceChildren(...facts.map(([name, text, title]) => make("span", { title }, make("span", { className: "quiet", textContent: name }), text)));
  }

  /** Shows why there is no session. @param {string} reason */
  end(reason) {
    get("sentence").textContent = reason;
    get("line").replaceChildren();
    get("figures").removeAttribute("open");
    get("figures").classList.remove("running");
  }
}
