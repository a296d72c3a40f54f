// The timeline of cues: the scenes and cues of the film in proportion to time, and styles to drop on scenes.

import { followPointer, make, title } from "./elements.js";
import { isEmpty, moved, timeOf } from "./cue_text.js";

/** @typedef {import("./cue_text.js").Sheet} Sheet @typedef {import("./cue_text.js").Cue} Cue */

const KEY_SECONDS = 0.1, LARGE_KEY_SECONDS = 1;
/** Distance of the pointer to the start of a scene within which a cue snaps to it. */
const SNAP_PX = 6;

/**
 * Shows the timeline in an element.
 * @param {HTMLElement} place
 * @param {Sheet} sheet
 * @param {Cue[]} cues in the order of time
 * @param {object} handlers
 * @param {(cues: Cue[]) => void} handlers.change is called with other cues
 * @param {(cue: Cue) => void} handlers.find is called to show the card of a cue
 * @param {(time: number) => void} handlers.seek is called with the start of a scene or cue that is chosen
 */
export function showTimeline(place, sheet, cues, { change, find, seek }) {
  const end = Number(sheet.end), used = cues.filter((cue) => !isEmpty(cue));
  const marks = used.map((cue, number) => {
    const next = used[number + 1], start = timeOf(sheet, cue);
    return mark(cue, start, (next ? timeOf(sheet, next) : end) - start);
  });
  const playhead = place.querySelector(".playhead") ?? make("i", { className: "playhead", hidden: true });
  place.replaceChildren(...sheet.scenes.map(sceneStrip), ...marks, playhead);

  /** Sets the place of an element by time. @param {HTMLElement} element @param {number} start @param {number} seconds */
  function put(element, start, seconds) {
    Object.assign(element.style, { left: `${100 * start / end}%`, width: `${100 * Math.max(0, seconds) / end}%` });
  }

  /** A scene, which takes styles that are dropped on it. @param {import("./cue_text.js").Scene} scene @param {number} number */
  function sceneStrip(scene, number) {
    const start = Number(scene.start), next = sheet.scenes[number + 1];
    const strip = make("div", { className: "scene", title: `Scene ${number + 1}, ${scene.clock}` });
    strip.style.backgroundImage = `url(${scene.still})`;
    put(strip, start, Number(next?.start ?? end) - start);
    strip.addEventListener("click", () => { seek(start); });
    takesStyles(strip, (style) => {
      const cue = cues.find((each) => each.scene === number && each.time === null);
      if (cue) Object.assign(cue, { style, variant: "", values: {} });
      change(cues);
    });
    return strip;
  }

  /** A cue, which can be moved. @param {Cue} cue @param {number} start @param {number} seconds */
  function mark(cue, start, seconds) {
    const made = make("button", { type: "button", className: "mark" }, cue.style ? title(cue.style) : "sliders");
    made.setAttribute("aria-label", `Change at ${start} s: ${cue.style ? title(cue.style) : "sliders"}; arrow keys move it`);
    made.dataset["place"] = `mark-${used.indexOf(cue)}`;
    put(made, start, seconds);
    let time = start;
    /** @param {number} snap seconds */
    const move = (snap) => change(moved(sheet, cues, cue, Math.min(Math.max(0, time), end), snap));
    followPointer(made, (event) => {
      const box = place.getBoundingClientRect();
      if (event.type === "pointerdown") made.dataset["grip"] = String(event.clientX - box.left - start / end * box.width);
      else time = (event.clientX - box.left - Number(made.dataset["grip"])) / box.width * end;
      made.style.left = `${100 * time / end}%`;
    });
    const choose = () => { find(cue); seek(start); };
    made.addEventListener("pointerup", () => (time === start ? choose() : move(SNAP_PX / place.clientWidth * end)));
    made.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (event.key === "Enter") choose();
      if (!step) return;
      event.preventDefault();
      time = start + step * (event.shiftKey ? LARGE_KEY_SECONDS : KEY_SECONDS);
      move(0);
    });
    return made;
  }
}

/** Shows where the film is. @param {HTMLElement} place of the timeline @param {number} share of the film, 0 to 1 */
export function showPlayhead(place, share) {
  const playhead = /** @type {HTMLElement | null} */ (place.querySelector(".playhead"));
  if (playhead) Object.assign(playhead, { hidden: false }).style.left = `${100 * share}%`;
}

/** Shows all styles, to be dragged. @param {HTMLElement} place @param {Sheet} sheet */
export function showStyles(place, sheet) {
  place.replaceChildren(...Object.entries(sheet.styles).map(([name, { picture }]) => {
    const shown = make("img", { src: picture, alt: "", draggable: false });
    shown.dataset["look"] = name;
    const tile = make("figure", { draggable: true, title: name }, shown, make("figcaption", {}, title(name)));
    tile.addEventListener("dragstart", (event) => event.dataTransfer?.setData("text/plain", name));
    return tile;
  }));
}

/** Lets an element take styles that are dropped on it. @param {HTMLElement} element @param {(style: string) => void} take */
export function takesStyles(element, take) {
  element.addEventListener("dragover", (event) => { event.preventDefault(); element.classList.add("target"); });
  element.addEventListener("dragleave", () => { element.classList.remove("target"); });
  element.addEventListener("drop", (event) => {
    event.preventDefault();
    element.classList.remove("target");
    const name = event.dataTransfer?.getData("text/plain");
    if (name) take(name);
  });
}
