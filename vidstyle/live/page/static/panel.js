// The panel beside the picture, built from the parameters of the style.

const $ = id => document.getElementById(id);

function make(kind, values = {}, ...inside) {
  const made = Object.assign(document.createElement(kind), values);
  made.append(...inside);
  return made;
}

const words = name => name.replaceAll("_", " ");
const stepName = path => words(path.split(".").at(-1).replace("#", " "));
const short = (number, whole) => whole ? Math.round(number) : Number(number.toPrecision(3));

const fullName = ({name, variant}) => variant ? `${name}:${variant}` : name;
const isShort = unit => Boolean(unit) && unit.length < 8;

// A slider whose range is wide gives most of its travel to the low values.
const isSteep = entry => !entry.whole && (entry.unit === "px" || (entry.low > 0 && entry.high / entry.low >= 20));
const NOTCHES = 400;

function scaleOf(entry) {
  const span = entry.high - entry.low;
  const power = isSteep(entry) ? 3 : 1;
  return {
    notches: entry.whole ? span : NOTCHES,
    place: value => Math.pow((value - entry.low) / span, 1 / power) * (entry.whole ? span : NOTCHES),
    value: place => entry.low + span * Math.pow(place / (entry.whole ? span : NOTCHES), power),
  };
}

/** A control for one parameter; it calls `change(value)` on input, and `show(value)` sets it. */
function control(entry, id, change) {
  if (entry.kind === "slider") return slider(entry, id, change);
  if (entry.kind === "switch") {
    const box = make("input", {type: "checkbox", id, onchange: () => change(box.checked)});
    return {beside: [box], show: value => { box.checked = value; }};
  }
  if (entry.kind === "color") {
    const well = make("input", {type: "color", id, oninput: () => change(well.value)});
    return {beside: [well], show: value => { well.value = value; }};
  }
  const menu = make("select", {id, onchange: () => change(menu.value)});
  const add = option => menu.append(make("option", {value: option, textContent: option ? words(option) : "none"}));
  entry.options.forEach(add);
  return {beside: [menu], show: value => {
    if (![...menu.options].some(option => option.value === value)) add(value);
    menu.value = value;
  }};
}

function slider(entry, id, change) {
  const scale = scaleOf(entry);
  const range = make("input", {type: "range", id, min: 0, max: scale.notches, step: entry.whole ? 1 : "any"});
  const exact = make("input", {type: "number", step: "any", min: entry.low, max: entry.high});
  exact.setAttribute("aria-label", `${words(entry.name)}, as a number`);
  const say = value => range.setAttribute("aria-valuetext", `${value} ${entry.unit}`.trim());
  const show = value => {
    range.value = scale.place(value);
    exact.value = short(value, entry.whole);
    say(exact.value);
  };
  const move = place => {
    const value = short(Math.min(Math.max(scale.value(place), entry.low), entry.high), entry.whole);
    exact.value = value;
    say(value);
    change(value);
  };
  range.oninput = () => move(Number(range.value));
  // With step "any" browsers disagree about arrow keys.
  range.onkeydown = event => {
    const steps = {ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10}[event.key];
    if (!steps || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    const step = Math.max(entry.whole ? 1 : 0, scale.notches / 100);
    range.value = Number(range.value) + steps * Math.round(step);
    move(Number(range.value));
  };
  exact.onchange = () => {
    if (exact.value === "" || !exact.checkValidity()) { exact.reportValidity(); return; }
    const value = entry.whole ? Math.round(exact.value) : Number(exact.value);
    range.value = scale.place(value);
    change(value);
  };
  const unit = isShort(entry.unit) || !entry.main ? [make("span", {textContent: entry.unit})] : [];
  return {beside: [exact, ...unit], below: [range], show};
}

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

  /** The session has answered a message; after an error the present values are shown again. */
  done(what, error) {
    if (what !== "set") return;
    this.#inFlight = null;
    if (error) this.show(this.#last);
    this.#flush();
  }

  /** A new connection: pending messages of the old one are never answered. */
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
    $("about").textContent = about || "The picture unchanged.";
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
    shown.control = control(entry, id, value => this.#set(shown, value, entry.path));
    const of = entry.main && entry.step ? `${stepName(entry.step)} ` : "";
    const label = make("label", {htmlFor: id, title: `${entry.help}\n${entry.path}`}, of + words(entry.name));
    label.ondblclick = () => { shown.control.show(shown.start); this.#set(shown, shown.start, entry.path); };
    const top = make("div", {className: "top"}, label, make("div", {className: "value"}, ...shown.control.beside));
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
