// The panel next to the picture, built from the parameters of the style.

import {control, isShort, short} from "./controls.js";
import {get as $, make, words} from "./elements.js";

const stepName = path => words(path.split(".").at(-1).replace("#", " "));
const fullName = ({name, variant}) => variant ? `${name}:${variant}` : name;

export class Panel {
  #send; #shown = {}; #queued = new Map(); #inFlight = null; #dragged = null; #name = null; #last = null;

  /** `send(message)` sends a message to the session. */
  constructor(send) {
    this.#send = send;
    addEventListener("pointerup", () => { this.#dragged = null; });
    $("reset").onclick = () => this.reset();
    $("copy").onclick = () => this.#copy();
  }

  names(names) {
    $("styles").replaceChildren(...names.map(name => {
      const picture = make("img", {src: `thumbnail.jpg?of=${encodeURIComponent(name)}`, alt: "", width: 240, height: 135});
      return make("button", {title: name, onclick: () => this.choose({do: "choose", style: name})}, picture,
        make("span", {textContent: name}));
    }));
    if (this.#last) this.#press();
  }

  choose(message) {
    this.#queued.clear();
    this.#send(message);
  }

  reset() {
    this.choose({do: "choose", style: fullName(this.#last)});
  }

  changeSteady(step) {
    const entry = this.#shown.steady;
    if (!entry) return;
    const value = short(Math.min(Math.max(entry.value + step, 0), 1));
    entry.control.show(value);
    this.#set(entry, value);
  }

  /** Handle the answer to a message; after an error, show the current values again. */
  done(what, error) {
    if (what !== "set") return;
    this.#inFlight = null;
    if (error) this.show(this.#last);
    this.#flush();
  }

  /** Discard pending messages, which a new connection never answers. */
  restart() {
    this.#inFlight = null;
    this.#queued.clear();
  }

  show(panel) {
    this.#last = panel;
    const name = JSON.stringify([panel.name, panel.entries.map(entry => entry.path)]);
    if (name !== this.#name) this.#build(panel);
    this.#name = name;
    for (const entry of panel.entries) this.#update(entry);
    $("options").textContent = panel.text;
    this.#press();
    for (const step of document.querySelectorAll("#steps details"))
      step.querySelector(".mark").hidden = !step.querySelector(".changed");
    $("reset").disabled = panel.entries.every(entry => entry.value === entry.start);
  }

  #update(entry) {
    const shown = this.#shown[entry.path];
    shown.box.classList.toggle("changed", entry.value !== entry.start);
    if (this.#dragged === entry.path || this.#queued.has(entry.path) || this.#inFlight?.has(entry.path)) return;
    shown.value = entry.value;
    shown.start = entry.start;
    if (!shown.box.contains(document.activeElement) || document.activeElement.type !== "number")
      shown.control.show(entry.value);
  }

  #press() {
    const {name, variant} = this.#last;
    const full = fullName(this.#last);
    // A session that was started with a variant lists it among the styles.
    const pressed = [...$("styles").children].some(button => button.textContent === full) ? full : name;
    for (const button of $("styles").children) {
      const chosen = button.textContent === pressed;
      if (chosen && button.getAttribute("aria-pressed") !== "true") this.#scrollTo(button);
      button.setAttribute("aria-pressed", chosen);
    }
    for (const button of $("variants").children)
      button.setAttribute("aria-pressed", button.textContent === variant);
  }

  // In a narrow window the styles are one long row; scrollIntoView would scroll the page too.
  #scrollTo(button) {
    const row = $("styles");
    row.scrollTo({left: button.offsetLeft - (row.clientWidth - button.clientWidth) / 2, behavior: "smooth"});
  }

  #build(panel) {
    this.#shown = {};
    const [about] = panel.note.split(" Tune ");
    $("about").textContent = about || "The unchanged picture.";
    $("variants").replaceChildren(...panel.variants.map(({name, ink, paper}) => {
      const swatch = make("span", {className: "swatch"});
      swatch.style.background = `linear-gradient(${paper} 50%, ${ink} 50%)`;
      return make("button", {onclick: () => this.choose({do: "choose", style: fullName({...panel, variant: name})})}, swatch,
        name);
    }));
    const main = panel.entries.filter(entry => entry.main);
    main.sort((one, other) => (other.path === "steady") - (one.path === "steady"));
    $("main").replaceChildren(...main.map(entry => this.#row(entry)));
    const layers = Map.groupBy(panel.entries.filter(entry => !entry.main), entry => entry.layer);
    $("steps").replaceChildren(...[...layers].flatMap(([layer, entries]) => this.#layer(layer, entries)));
    $("all").hidden = !layers.size;
  }

  #layer(layer, entries) {
    const steps = [...Map.groupBy(entries, entry => entry.step)].map(([step, inside]) => this.#step(step, inside));
    return layer ? [make("h3", {textContent: layer}), ...steps] : steps;
  }

  #step(step, entries) {
    const mark = make("span", {className: "mark", textContent: " changed", hidden: true});
    const about = entries[0].about ? [make("p", {className: "about", textContent: entries[0].about})] : [];
    const inside = make("div", {}, ...about, ...entries.map(entry => this.#row(entry)));
    return make("details", {}, make("summary", {}, step ? stepName(step) : "size", mark), inside);
  }

  #row(entry) {
    const id = `value-${entry.path}`;
    const shown = {value: entry.value, start: entry.start};
    const described = entry.main && !isShort(entry.unit) ? {...entry, unit: ""} : entry;
    shown.control = control(described, id, value => this.#set(shown, value, entry.path));
    const of = entry.main && entry.step ? `${stepName(entry.step)} ` : "";
    const label = make("label", {htmlFor: id, title: `${entry.help}\n${entry.path}`}, of + words(entry.name));
    label.ondblclick = () => { shown.control.show(shown.start); this.#set(shown, shown.start, entry.path); };
    const top = make("div", {className: "top"}, label, make("div", {className: "value"}, ...shown.control.inline));
    const unit = entry.unit && !isShort(entry.unit) ? ` (${entry.unit})` : "";
    const help = entry.main ? [make("p", {className: "help", textContent: entry.help + unit})] : [];
    shown.box = make("div", {className: "entry", title: entry.help}, top, ...(shown.control.below ?? []), ...help);
    shown.box.onpointerdown = () => { this.#dragged = entry.path; };
    shown.path = entry.path;
    shown.control.show(entry.value);
    this.#shown[entry.path] = shown;
    return shown.box;
  }

  #set(shown, value) {
    shown.value = value;
    this.#queued.set(shown.path, value);
    this.#flush();
  }

  #flush() {
    if (this.#inFlight || !this.#queued.size) return;
    this.#inFlight = this.#queued;
    this.#queued = new Map();
    this.#send({do: "set", values: Object.fromEntries(this.#inFlight)});
  }

  async #copy() {
    try {
      await navigator.clipboard.writeText($("options").textContent);
      $("copy").textContent = "Copied";
    } catch {
      getSelection().selectAllChildren($("options"));
      $("copy").textContent = "Selected";
    }
    setTimeout(() => { $("copy").textContent = "Copy"; }, 1500);
  }
}
