// Edits the cues of a film: a timeline, styles to drop on it, and a card for each cue.

import { get, make, press, title } from "./elements.js";
import { control } from "./controls.js";
import { cueFile, emptyCue, firstCues, inOrder, mistake, sceneAt, timeOf } from "./cue_text.js";
import { showStyles, showTimeline, takesStyles } from "./timeline.js";

/** @typedef {import("./cue_text.js").Cue} Cue */

const FADE_SECONDS = 1;
const CURVE_LABELS = /** @type {Record<string, string>} */ ({
  hold: "stay as they are", linear: "move evenly to the next", ease: "move gently to the next",
});
let controls = 0;

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

/** Shows and edits cues in the elements `timeline`, `styles`, `cues` and the dialog `cue-styles` of the page. */
export class CueEditor {
  /** Cues whose values are shown. @type {Set<Cue>} */
  #opened = new Set();
  /** The cues after each change, as JSON. @type {string[]} */
  #states;
  /** The number of the present state. */
  #now = 0;
  /** What the last change was a change of. */
  #changing = "";

  /**
   * @param {import("./cue_text.js").Sheet} sheet
   * @param {object} handlers
   * @param {() => void} [handlers.onchange] is called after each change
   * @param {(time: number) => void} [handlers.seek] is called with the time of what is chosen on the timeline
   * @param {string} [state] an earlier `state`, to go on with
   */
  constructor(sheet, { onchange = () => {}, seek = () => {} } = {}, state = "") {
    this.sheet = sheet;
    this.onchange = onchange;
    this.seek = seek;
    /** @type {Cue[]} */
    this.cues = state ? JSON.parse(state) : firstCues(sheet);
    this.#states = [JSON.stringify(this.cues)];
    showStyles(get("styles"), sheet);
    const dialog = /** @type {HTMLDialogElement} */ (get("cue-styles"));
    /** @type {HTMLElement} */ (dialog.querySelector("header button")).onclick = () => dialog.close();
    this.#show();
  }

  /** What is wrong with the cues, or "". */
  get mistake() {
    return mistake(this.sheet, this.cues);
  }

  /** The cues, as JSON. */
  get state() {
    return String(this.#states[this.#now]);
  }

  /** The text of the cue file. */
  get text() {
    return cueFile(this.sheet, this.cues);
  }

  /** Whether there is a change to undo, or to make again. @param {-1 | 1} step */
  has(step) {
    return this.#states[this.#now + step] !== undefined;
  }

  /** Undoes a change, or makes it again. @param {-1 | 1} step */
  undo(step = -1) {
    const state = this.#states[this.#now + step];
    if (!state) return;
    this.#now += step;
    this.#changing = "";
    this.cues = JSON.parse(state);
    this.#show();
    this.onchange();
  }

  /** Keeps the changed cues. @param {string} [of] what changed; successive changes of the same are undone together */
  #changed(of = "") {
    if (!of || of !== this.#changing) this.#now += 1;
    this.#changing = of;
    this.#states.splice(this.#now, Infinity, JSON.stringify(this.cues));
    this.onchange();
  }

  /** Shows other cues. @param {Cue[]} [cues] */
  #show(cues = this.cues) {
    const list = get("cues"), focused = document.activeElement?.getAttribute("data-place");
    this.cues = inOrder(this.sheet, cues);
    list.replaceChildren(...this.cues.map((cue, number) => this.#card(cue, number)));
    showTimeline(get("timeline"), this.sheet, this.cues, {
      change: (changed) => this.#replace(changed),
      find: (cue) => { list.children[this.cues.indexOf(cue)]?.scrollIntoView({ block: "center" }); },
      seek: this.seek,
    });
    const place = focused && document.querySelector(`[data-place="${focused}"]`);
    if (place instanceof HTMLElement) place.focus();
  }

  /** Shows and keeps changed cues. @param {Cue[]} [cues] */
  #replace(cues = this.cues) {
    this.#show(cues);
    this.#changed();
  }

  /** The style and the values at a cue, before its own values. @param {number} number */
  #inherited(number) {
    let first = number;
    while (first > 0 && !this.cues[first]?.style) first -= 1;
    const { style = "", variant = "" } = this.cues[first] ?? {};
    const values = { ...this.sheet.styles[style]?.variants[variant] };
    for (const cue of this.cues.slice(first, number)) Object.assign(values, cue.values);
    return { style, values };
  }

  /** @param {Cue} cue @param {number} number */
  #card(cue, number) {
    const { sheet } = this;
    const scene = /** @type {import("./cue_text.js").Scene} */ (sheet.scenes[cue.scene]);
    const name = cue.time === null ? `Scene ${cue.scene + 1}, ${scene.clock}` : `Scene ${cue.scene + 1}, at ${cue.time} s`;
    const picture = make("img", { alt: "", src: sheet.styles[cue.style]?.picture ?? scene.still });
    picture.dataset["look"] = cue.style;
    const chosen = cue.style ? title(cue.style) : this.#unchanged(number);
    const style = make("button", { type: "button", className: "style" }, picture, make("span", {}, chosen));
    style.setAttribute("aria-label", `Look of ${name}: ${chosen}`);
    style.dataset["place"] = `style-${number}`;
    style.addEventListener("click", () => { this.#pick(name, number, cue); });
    const variants = Object.keys(sheet.styles[cue.style]?.variants ?? {});
    const variant = choice(["", ...variants], cue.variant, (word) => { cue.variant = word; this.#replace(); }, (word) => word || "none");
    const seconds = secondsInput("Seconds of the transition", cue.seconds || FADE_SECONDS, "0.1", (value) => { cue.seconds = value; this.#changed(); });
    seconds.hidden = cue.transition === "cut";
    const transition = choice(sheet.transitions, cue.transition, (word) => {
      cue.transition = word;
      seconds.hidden = word === "cut";
      cue.seconds = word === "cut" ? 0 : seconds.valueAsNumber || FADE_SECONDS;
      this.#changed();
    });
    const curve = choice(sheet.curves, cue.curve, (word) => { cue.curve = word; this.#changed(); }, (word) => CURVE_LABELS[word] ?? word);
    const start = secondsInput("Start in seconds", cue.time ?? 0, "0", (value) => { cue.time = value; cue.scene = sceneAt(sheet, value); this.#replace(); });
    const made = make("li", {},
      make("img", { src: scene.still, alt: `Scene ${cue.scene + 1}` }),
      make("h2", {}, name),
      make("div", { className: "fields" },
        ...(cue.time === null ? [] : row("Starts at", start)), ...row("Look", style),
        ...(variants.length ? row("Variant", variant) : []), ...row("Begins with", transition, seconds), ...row("Sliders", curve)),
      this.#values(cue, number), this.#buttons(cue));
    takesStyles(made, (dropped) => { this.#choose(cue, dropped); });
    return made;
  }

  /** Chooses another style for a cue. @param {Cue} cue @param {string} style */
  #choose(cue, style) {
    if (style === cue.style) return this.#show();
    Object.assign(cue, { style, variant: "", values: {} });
    this.#replace();
  }

  /** The values of a cue, which are shown on demand. @param {Cue} cue @param {number} number */
  #values(cue, number) {
    const details = make("details", { open: this.#opened.has(cue) }, make("summary", {}, "Sliders of this look"));
    const fill = () => {
      const { style, values: before } = this.#inherited(number);
      for (const entry of details.childElementCount > 1 ? [] : this.sheet.styles[style]?.entries ?? []) {
        const id = `control-${controls += 1}`;
        const made = control(entry, id, (value) => {
          cue.values[entry.path] = value;
          this.#changed(`${number} ${entry.path}`);
        });
        made.show(cue.values[entry.path] ?? before[entry.path] ?? entry.value);
        const label = make("label", { htmlFor: id, title: entry.help ?? "" }, entry.label);
        const line = make("div", { className: "value" }, label, ...made.inline, ...(made.below ?? []));
        line.dataset["path"] = entry.path;
        details.append(line);
      }
    };
    details.addEventListener("toggle", () => {
      this.#opened[details.open ? "add" : "delete"](cue);
      fill();
    });
    if (details.open) fill();
    return details;
  }

  /** What a scene without a style shows. @param {number} number */
  #unchanged(number) {
    const { style } = this.#inherited(number);
    return style ? `Still ${title(style)}` : "Choose a look";
  }

  /** Shows another picture of a style. @param {string} style @param {string} address */
  showLook(style, address) {
    const known = this.sheet.styles[style];
    if (!known || known.picture === address) return;
    known.picture = address;
    for (const picture of document.querySelectorAll(`[data-look="${CSS.escape(style)}"]`)) /** @type {HTMLImageElement} */ (picture).src = address;
  }

  /** Buttons that add a cue after a cue, and remove it. @param {Cue} cue */
  #buttons(cue) {
    const add = make("button", { type: "button", className: "add" }, "Add a change after it");
    add.addEventListener("click", () => {
      const time = Number((timeOf(this.sheet, cue) + 1).toFixed(3));
      this.#replace([...this.cues, emptyCue(sceneAt(this.sheet, time), time)]);
    });
    const remove = make("button", { type: "button", className: "remove", hidden: cue.time === null }, "Remove");
    remove.addEventListener("click", () => this.#replace(this.cues.filter((each) => each !== cue)));
    return make("div", { className: "buttons" }, add, remove);
  }

  /** Let the user choose a style in a dialog. @param {string} place @param {number} number @param {Cue} cue */
  #pick(place, number, cue) {
    const { styles } = this.sheet;
    const dialog = /** @type {HTMLDialogElement} */ (get("cue-styles"));
    const names = [...Object.keys(styles), ...(number ? [""] : [])];
    /** @type {HTMLElement} */ (dialog.querySelector("strong")).textContent = `Look of ${place}`;
    /** @type {HTMLElement} */ (dialog.querySelector("div")).replaceChildren(...names.map((name) => {
      const pictures = name ? [make("img", { src: styles[name]?.picture ?? "", alt: "" })] : [];
      for (const each of pictures) each.dataset["look"] = name;
      const button = make("button", { type: "button" }, ...pictures, name ? title(name) : "As the scene before");
      press(button, name === cue.style);
      button.addEventListener("click", () => {
        dialog.close();
        this.#choose(cue, name);
      });
      return button;
    }));
    dialog.showModal();
  }
}
