// The page of a cue sheet: a card for each scene, and the text of the cue file. `vidstyle.gallery.cue_sheet` joins it
// with the module that it imports.

import { download, get, make, press } from "./elements.js";

/**
 * @typedef {{ start: string, clock: string, style: string, still: string }} Scene
 * @typedef {{ file: string, rate: string | null, scenes: Scene[], styles: Record<string, string>,
 *   transitions: string[], curves: string[] }} Sheet
 * @typedef {{ style: string, transition: string, seconds: number, strength: number, curve: string }} Cue
 */

/** @type {Sheet} */
const sheet = JSON.parse(get("data").textContent ?? "");
const FADE_SECONDS = 1;
const CURVE_LABELS = /** @type {Record<string, string>} */ ({
  hold: "unchanged", linear: "moves evenly to the next scene's values", ease: "moves gently to the next scene's values",
});

/** @type {Cue[]} */
const cues = sheet.scenes.map(({ style }) => ({ style, transition: "cut", seconds: 0, strength: 1, curve: "hold" }));

let controls = 0;

/**
 * A labelled row of a card.
 * @param {string} text
 * @param {HTMLElement} control
 * @param {...HTMLElement} more
 */
function row(text, control, ...more) {
  control.id = `control-${controls += 1}`;
  return [make("label", { htmlFor: control.id }, text), make("span", { className: "how" }, control, ...more)];
}

/**
 * A choice of one of some words.
 * @param {string[]} words
 * @param {(word: string) => void} choose
 * @param {(word: string) => string} label
 */
function choice(words, choose, label = (word) => word) {
  const made = make("select", {}, ...words.map((word) => make("option", { value: word }, label(word))));
  made.addEventListener("change", () => { choose(made.value); });
  return made;
}

/** @param {Scene} scene @param {number} number */
function card(scene, number) {
  const cue = /** @type {Cue} */ (cues[number]);
  const picture = make("img", { alt: "" }), name = make("span");
  const style = make("button", { type: "button", className: "style" }, picture, name);
  const show = () => {
    name.textContent = cue.style || "as before";
    picture.src = sheet.styles[cue.style] ?? scene.still;
    style.setAttribute("aria-label", `Style of scene ${number + 1}: ${name.textContent}`);
  };
  style.addEventListener("click", () => { pickStyle(number, cue.style, (chosen) => { cue.style = chosen; show(); }); });
  show();
  const seconds = make("input", { type: "number", min: "0.1", step: "0.1", value: String(FADE_SECONDS), hidden: true });
  seconds.setAttribute("aria-label", `Seconds of the transition of scene ${number + 1}`);
  seconds.addEventListener("input", () => { cue.seconds = seconds.valueAsNumber || 0; });
  const transition = choice(sheet.transitions, (word) => {
    cue.transition = word;
    seconds.hidden = word === "cut";
    cue.seconds = word === "cut" ? 0 : seconds.valueAsNumber || FADE_SECONDS;
  });
  const strength = make("input", { type: "range", min: "0", max: "1", step: "0.05", value: "1" });
  const shown = make("output", {}, "1");
  strength.addEventListener("input", () => { cue.strength = strength.valueAsNumber; shown.textContent = strength.value; });
  const curve = choice(sheet.curves, (word) => { cue.curve = word; }, (word) => CURVE_LABELS[word] ?? word);
  return make("li", {},
    make("img", { src: scene.still, alt: `Scene ${number + 1}` }),
    make("h2", {}, `Scene ${number + 1}, ${scene.clock}`),
    make("div", { className: "fields" },
      ...row("Style", style), ...row("Begins with", transition, seconds), ...row("Strength", strength, shown),
      ...row("Values", curve)));
}

/**
 * Let the user choose a style in a dialog.
 * @param {number} number of the scene
 * @param {string} current
 * @param {(style: string) => void} choose
 */
function pickStyle(number, current, choose) {
  const dialog = /** @type {HTMLDialogElement} */ (document.querySelector("dialog"));
  const names = [...Object.keys(sheet.styles), ...(number ? [""] : [])];
  /** @type {HTMLElement} */ (dialog.querySelector("strong")).textContent = `Style of scene ${number + 1}`;
  /** @type {HTMLElement} */ (dialog.querySelector("div")).replaceChildren(...names.map((name) => {
    const pictures = name ? [make("img", { src: sheet.styles[name] ?? "", alt: "" })] : [];
    const button = make("button", { type: "button" }, ...pictures, name || "as before");
    press(button, name === current);
    button.addEventListener("click", () => { choose(name); dialog.close(); });
    return button;
  }));
  dialog.showModal();
}

/** The text of the cue file. */
function cueFile() {
  const lines = [
    `# The styles of a film over time: vidstyle render FILM OUTPUT --cues ${sheet.file}`, "format = 1",
    ...(sheet.rate === null ? [] : [`rate = ${sheet.rate}`]),
    `scenes = [${sheet.scenes.map(({ start }) => start).join(", ")}]`,
  ];
  let strength = 1;
  cues.forEach((cue, number) => {
    const continues = !cue.style && cue.transition === "cut" && cue.strength === strength && cue.curve === "hold";
    if (number && continues) return;
    lines.push("", "[[cue]]", `scene = ${number + 1}`);
    if (cue.style) lines.push(`style = ${JSON.stringify(cue.style)}`);
    if (cue.strength !== 1 || (!cue.style && strength !== 1)) lines.push(`values = { strength = ${cue.strength} }`);
    if (cue.transition !== "cut") lines.push(`transition = "${cue.transition}"`, `seconds = ${cue.seconds}`);
    if (cue.curve !== "hold") lines.push(`curve = "${cue.curve}"`);
    strength = cue.strength;
  });
  return `${lines.join("\n")}\n`;
}

const answer = /** @type {HTMLElement} */ (document.querySelector("footer output"));
/** @type {HTMLElement} */ (document.querySelector(".save")).addEventListener("click", () => {
  download(new Blob([cueFile()], { type: "application/toml" }), sheet.file);
  answer.textContent = `Saved as ${sheet.file} in your downloads: vidstyle render FILM OUTPUT --cues ${sheet.file}`;
});
/** @type {HTMLElement} */ (document.querySelector(".copy")).addEventListener("click", async () => {
  await navigator.clipboard.writeText(cueFile());
  answer.textContent = "The text of the cue file is in the clipboard.";
});
/** @type {HTMLElement} */ (document.querySelector("ol")).append(...sheet.scenes.map(card));
