// The page of a cue sheet: a card for each cue. `vidstyle.gallery.cue_sheet` joins it with the modules that it imports.

import { download, get, make, press } from "./elements.js";
import { control } from "./controls.js";
import { cueFile, emptyCue, firstCues, inOrder, mistake, sceneAt, timeOf } from "./cue_text.js";
import { showStyles, showTimeline, takesStyles } from "./timeline.js";

/** @typedef {import("./cue_text.js").Cue} Cue */

/** @type {import("./cue_text.js").Sheet} */
const sheet = JSON.parse(get("data").textContent ?? "");
const FADE_SECONDS = 1;
const CURVE_LABELS = /** @type {Record<string, string>} */ ({
  hold: "stay", linear: "move evenly to the next", ease: "move gently to the next",
});

let cues = firstCues(sheet);
/** Cues whose values are shown. @type {Set<Cue>} */
const opened = new Set();
let controls = 0;
const list = /** @type {HTMLElement} */ (document.querySelector("ol"));
const answer = /** @type {HTMLElement} */ (document.querySelector("footer output"));

/**
 * A labelled row of a card.
 * @param {string} text
 * @param {HTMLElement} input
 * @param {...HTMLElement} more
 */
function row(text, input, ...more) {
  input.id ||= `control-${controls += 1}`;
  return [make("label", { htmlFor: input.id }, text), make("span", { className: "how" }, input, ...more)];
}

/**
 * A choice of one of some words.
 * @param {string[]} words
 * @param {string} chosen
 * @param {(word: string) => void} choose
 * @param {(word: string) => string} label
 */
function choice(words, chosen, choose, label = (word) => word) {
  const made = make("select", {}, ...words.map((word) => make("option", { value: word, selected: word === chosen }, label(word))));
  made.addEventListener("change", () => { choose(made.value); });
  return made;
}

/**
 * An input for seconds.
 * @param {string} label
 * @param {number} value
 * @param {string} min
 * @param {(seconds: number) => void} change
 */
function secondsInput(label, value, min, change) {
  const input = make("input", { type: "number", min, step: "any", value: String(value) });
  input.setAttribute("aria-label", label);
  input.addEventListener("change", () => { if (input.reportValidity() && input.value) change(input.valueAsNumber); });
  return input;
}

/** Shows all cards again, and the focus where it was. */
function show() {
  const focused = document.activeElement?.getAttribute("data-place");
  cues = inOrder(sheet, cues);
  list.replaceChildren(...cues.map(card));
  showTimeline(get("timeline"), sheet, cues, {
    change: (changed) => { cues = changed; show(); },
    find: (cue) => { list.children[cues.indexOf(cue)]?.scrollIntoView({ block: "center" }); },
  });
  const place = focused && document.querySelector(`[data-place="${focused}"]`);
  if (place instanceof HTMLElement) place.focus();
}

/** The style and the values at a cue, before its own values. @param {number} number */
function inherited(number) {
  let first = number;
  while (first > 0 && !cues[first]?.style) first -= 1;
  const { style = "", variant = "" } = cues[first] ?? {};
  const values = { ...sheet.styles[style]?.variants[variant] };
  for (const cue of cues.slice(first, number)) Object.assign(values, cue.values);
  return { style, values };
}

/** @param {Cue} cue @param {number} number */
function card(cue, number) {
  const scene = /** @type {import("./cue_text.js").Scene} */ (sheet.scenes[cue.scene]);
  const name = cue.time === null ? `Scene ${cue.scene + 1}, ${scene.clock}` : `Scene ${cue.scene + 1}, at ${cue.time} s`;
  const picture = make("img", { alt: "", src: sheet.styles[cue.style]?.picture ?? scene.still });
  const style = make("button", { type: "button", className: "style" }, picture, make("span", {}, cue.style || "as before"));
  style.setAttribute("aria-label", `Style of ${name}: ${cue.style || "as before"}`);
  style.dataset["place"] = `style-${number}`;
  style.addEventListener("click", () => { pickStyle(name, number, cue); });
  const variants = Object.keys(sheet.styles[cue.style]?.variants ?? {});
  const variant = choice(["", ...variants], cue.variant, (word) => { cue.variant = word; show(); }, (word) => word || "none");
  const seconds = secondsInput("Seconds of the transition", cue.seconds || FADE_SECONDS, "0.1", (value) => { cue.seconds = value; });
  seconds.hidden = cue.transition === "cut";
  const transition = choice(sheet.transitions, cue.transition, (word) => {
    cue.transition = word;
    seconds.hidden = word === "cut";
    cue.seconds = word === "cut" ? 0 : seconds.valueAsNumber || FADE_SECONDS;
  });
  const curve = choice(sheet.curves, cue.curve, (word) => { cue.curve = word; }, (word) => CURVE_LABELS[word] ?? word);
  const start = secondsInput("Start in seconds", cue.time ?? 0, "0", (value) => { cue.time = value; cue.scene = sceneAt(sheet, value); show(); });
  const made = make("li", {},
    make("img", { src: scene.still, alt: `Scene ${cue.scene + 1}` }),
    make("h2", {}, name),
    make("div", { className: "fields" },
      ...(cue.time === null ? [] : row("Starts at", start)), ...row("Style", style),
      ...(variants.length ? row("Variant", variant) : []), ...row("Begins with", transition, seconds), ...row("Values", curve)),
    values(cue, number), buttons(cue));
  takesStyles(made, (dropped) => { choose(cue, dropped); });
  return made;
}

/** Chooses another style for a cue. @param {Cue} cue @param {string} style */
function choose(cue, style) {
  if (style !== cue.style) Object.assign(cue, { style, variant: "", values: {} });
  show();
}

/** The values of a cue, which are shown on demand. @param {Cue} cue @param {number} number */
function values(cue, number) {
  const details = make("details", { open: opened.has(cue) }, make("summary", {}, "Values of the style"));
  const fill = () => {
    const { style, values: before } = inherited(number);
    for (const entry of details.childElementCount > 1 ? [] : sheet.styles[style]?.entries ?? []) {
      const id = `control-${controls += 1}`;
      const made = control(entry, id, (value) => { cue.values[entry.path] = value; });
      made.show(cue.values[entry.path] ?? before[entry.path] ?? entry.value);
      const label = make("label", { htmlFor: id, title: entry.help ?? "" }, entry.label);
      const line = make("div", { className: "value" }, label, ...made.inline, ...(made.below ?? []));
      line.dataset["path"] = entry.path;
      details.append(line);
    }
  };
  details.addEventListener("toggle", () => {
    opened[details.open ? "add" : "delete"](cue);
    fill();
  });
  if (details.open) fill();
  return details;
}

/** Buttons that add a cue after a cue, and remove it. @param {Cue} cue */
function buttons(cue) {
  const add = make("button", { type: "button", className: "add" }, "Add a cue after it");
  add.addEventListener("click", () => {
    const time = Number((timeOf(sheet, cue) + 1).toFixed(3));
    cues.push(emptyCue(sceneAt(sheet, time), time));
    show();
  });
  const remove = make("button", { type: "button", className: "remove", hidden: cue.time === null }, "Remove");
  remove.addEventListener("click", () => { cues = cues.filter((each) => each !== cue); show(); });
  return make("div", { className: "buttons" }, add, remove);
}

/** Let the user choose a style in a dialog. @param {string} place @param {number} number @param {Cue} cue */
function pickStyle(place, number, cue) {
  const dialog = /** @type {HTMLDialogElement} */ (document.querySelector("dialog"));
  const names = [...Object.keys(sheet.styles), ...(number ? [""] : [])];
  /** @type {HTMLElement} */ (dialog.querySelector("strong")).textContent = `Style of ${place}`;
  /** @type {HTMLElement} */ (dialog.querySelector("div")).replaceChildren(...names.map((name) => {
    const pictures = name ? [make("img", { src: sheet.styles[name]?.picture ?? "", alt: "" })] : [];
    const button = make("button", { type: "button" }, ...pictures, name || "as before");
    press(button, name === cue.style);
    button.addEventListener("click", () => {
      dialog.close();
      choose(cue, name);
    });
    return button;
  }));
  dialog.showModal();
}

/** Gives the text of the cue file to `use`, or says what is wrong. @param {(text: string) => Promise<string> | string} use */
async function withText(use) {
  answer.textContent = mistake(sheet, cues) || await use(cueFile(sheet, cues));
}

/** @type {HTMLElement} */ (document.querySelector(".save")).addEventListener("click", () => withText((text) => {
  download(new Blob([text], { type: "application/toml" }), sheet.file);
  return `Saved as ${sheet.file} in your downloads: vidstyle render FILM OUTPUT --cues ${sheet.file}`;
}));
/** @type {HTMLElement} */ (document.querySelector(".copy")).addEventListener("click", () => withText(async (text) => {
  await navigator.clipboard.writeText(text);
  return "The text of the cue file is in the clipboard.";
}));
showStyles(get("styles"), sheet);
show();
