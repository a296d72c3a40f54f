// The designer: creates the parts of the page and connects them.

import { announce } from "./announce.js";
import { Bar } from "./bar.js";
import { Diagram } from "./diagram.js";
import { Clipboard } from "./clipboard.js";
import { keepTabInDialogs } from "./dialog_tab.js";
import { Dialogs } from "./dialogs.js";
import { DraftList } from "./draft_list.js";
import { get, icon, make, press, title } from "./elements.js";
import { History } from "./history.js";
import { Inspector } from "./inspector.js";
import { describe, listen } from "./keys.js";
import { LostNotice } from "./lost.js";
import { PACKET, Preview } from "./preview.js";
import { Palette } from "./palette.js";
import { Queue } from "./queue.js";
import { Scenes } from "./scenes.js";
import { Scopes } from "./scopes.js";
import { Session } from "./session.js";
import { Splitter } from "./splitter.js";
import { Start, START_KEYS } from "./start.js";
import { Steps } from "./steps.js";
import { switchTheme } from "./theme.js";
import { StylePanel } from "./style_panel.js";
import { shortcuts } from "./shortcuts.js";

for (const place of document.querySelectorAll("[data-icon]"))
  place.prepend(icon(String(/** @type {HTMLElement} */ (place).dataset.icon)));

/** Shows a message, or only announces it. @param {string} text @param {boolean} [alarm] @param {boolean} [visible] */
function say(text, alarm = false, visible = true) {
  const toast = get("toast");
  // The newest popover is on top: messages are seen above the queue and dialogs.
  if (toast.matches(":popover-open")) toast.hidePopover();
  toast.showPopover();
  announce(toast, text, { alarm, visible });
}
const session = new Session((text) => say(text, true));
const palette = new Palette(session, showField);
const dialogs = new Dialogs(session, say);
const preview = new Preview(session, { onchange: () => showPlace(), onsettled: drawResult });
const bar = new Bar(preview, say);
const scenes = new Scenes(session, preview, { say, onopen: showScenes, onchange: showUndo, pictureOf: (style) => start.pictureOf(style) });
const scopes = new Scopes(preview.view);
const steps = new Steps(session, palette, say, showSelected, (name) => diagram.focus(name));
const clipboard = new Clipboard(session, steps, say);
steps.onadd = () => preview.announce();
steps.onpaste = (layer, index) => clipboard.paste(clipboard.kept, layer, index);
palette.canPaste = () => Boolean(clipboard.kept);
const splitter = new Splitter(() => diagram.arrange());
const diagram = new Diagram({
  select: (name) => steps.select(name),
  add: (layer, index, near) => steps.add(layer, index, near),
  move: (step, layer, index) => steps.move(step, layer, index),
  showBehindLines: () => steps.showBehindLines(),
}, () => splitter.maxHeight);
const inspector = new Inspector(session, act);
const stylePanel = new StylePanel(session, () => {
  build(true);
  steps.select("source");
  steps.addAfter(get("panel").getBoundingClientRect());
});
const history = new History(session, () => {
  if (preview.view.mode === "result") preview.view.setMode("split");
  preview.compareWith("opened");
});
const queue = new Queue(session);
dialogs.onplay = () => queue.playNewest();
dialogs.onpicture = () => document.body.classList.contains("front") || queue.play();
const start = new Start(session, say, (kind) => {
  history.clear();
  preview.compareWith("source");
  preview.view.setZoom(null);
  steps.selected = null;
  opening = kind;
});

new DraftList(session, (place) => start.open("draft", { accept: true, place }));

/** How the document being opened was requested; "" once it has arrived. */
let opening = "";
/** @typedef {"step" | "style" | "scenes" | "history"} Tab */
/** @type {Tab} */
let tab = "style";

get("step-tab-content").append(inspector.element, make("p", { className: "quiet", id: "film-facts" }));
get("style-tab-content").append(stylePanel.element);
get("history-tab-content").append(history.element);

/** @param {Tab} name */
function showTab(name) {
  tab = name;
  for (const button of get("tabs").querySelectorAll("button")) {
    const chosen = button.value === name;
    button.setAttribute("aria-selected", String(chosen));
    button.tabIndex = chosen ? 0 : -1;
    get(`${button.value}-tab-content`).hidden = !chosen;
  }
  showUndo();
}

/** Shows what the buttons undo and redo: edits of the style, or of the cues while these are shown. */
function showUndo() {
  for (const which of /** @type {const} */ (["undo", "redo"])) {
    const button = /** @type {HTMLButtonElement} */ (get(which)), edit = tab === "scenes" ? "" : session.state?.[which];
    button.disabled = tab === "scenes" ? !scenes.has(which) : !edit;
    button.title = `${which === "undo" ? "Undo" : "Redo"}${edit ? `: ${edit}` : ""} (Ctrl+${which === "undo" ? "Z" : "Y"})`;
  }
}

/** Shows the position in the film and the view. */
function showPlace() {
  bar.show();
  scenes.follow();
}

/** Shows or hides the tab of the scenes. @param {boolean} on */
function showScenes(on) {
  /** @type {HTMLElement} */ (get("tabs").querySelector("[value=scenes]")).hidden = !on;
  if (on || tab === "scenes") showTab(on ? "scenes" : "style");
}

/** Undoes or redoes an edit of what is shown: the cues or the style. @param {"undo" | "redo"} which */
function again(which) {
  return tab === "scenes" ? scenes.again(which) : steps.again(which);
}

/** Shows a setting of the style and focuses it. @param {string} name */
function showField(name) {
  showTab("style");
  stylePanel.focus(name);
}

/** @param {boolean} on whether the diagram is shown */
function build(on) {
  document.body.classList.toggle("building", on);
  press(get("to-diagram"), on);
  const step = /** @type {HTMLElement} */ (get("tabs").querySelector("[value=step]"));
  step.hidden = !on;
  if (!on && tab === "step") showTab("style");
  if (!on && preview.solo !== null) solo(null);
  diagram.arrange();
}

function showSelected() {
  diagram.selected = steps.selected;
  diagram.mark();
  if (steps.selected === "result") showTab("style");
  else if (steps.selected !== null) showTab("step");
  refresh();
}

function refresh() {
  const { state } = session;
  if (!state) return;
  const { step } = steps;
  inspector.element.hidden = !step;
  get("film-facts").hidden = Boolean(step);
  const { name, size, count, fps } = preview.player.clip;
  const length = count > 1 ? `, ${count} frames at ${Number(fps.toFixed(3))} fps` : "";
  get("film-facts").textContent = steps.selected === null ? "Select a step in the diagram." : `${name.split(/[\\/]/).at(-1)}: ${size.join(" × ")}${length}.`;
  if (step) inspector.show(state, step, preview.solo === step.step);
  stylePanel.show(state);
  history.show(state);
  bar.show();
}

/** Whether no document has arrived since the page was loaded. */
let isFirst = true;

/** @param {import("./types.js").State | null} state */
function showState(state) {
  get("opening").hidden = true;
  const isAtStart = isFirst && start.isShownFirst;
  isFirst = false;
  if (!state || isAtStart) start.show(true);
  if (!state) return;
  if (state.errors.length) preview.withdraw();
  if (opening) {
    const fresh = opening;
    opening = "";
    start.show(false); // elements behind the start screen cannot take the focus
    build(fresh === "new" || state.knobs.length === 0);
    showTab("style");
    get("style-tab-content").scrollTop = 0;
    if (fresh === "new") steps.selected = "source";
    requestAnimationFrame(() => fresh === "new" && diagram.focus("source"));
    preview.begin();
    diagram.clearResult();
  }
  steps.deselectRemoved();
  if (preview.solo !== null && !steps.step) preview.solo = null;
  diagram.solo = preview.solo;
  diagram.selected = steps.selected;
  diagram.show(state);
  const name = /** @type {HTMLInputElement} */ (get("name"));
  if (document.activeElement !== name) name.value = title(state.name);
  get("saved").textContent = state.dirty ? "Edited" : state.file ? "Saved" : "";
  showUndo();
  document.title = `${state.dirty ? "• " : ""}${title(state.name)} · vidstyle design`;
  refresh();
}

function drawResult() {
  const { source, result } = preview.view;
  const { state } = session;
  if (!state || !source || !result) return;
  diagram.draw("source", source.picture, source.size);
  if (preview.solo !== null || scenes.isOpen) return;
  diagram.draw("result", result.picture, result.size);
  // After quick edits, the picture may still show an earlier state.
  if (preview.revision === state.revision) history.draw(state, result.picture, result.size);
}

/** Shows the output of a step, or the result. @param {number | null} step null: the result */
async function solo(step) {
  await preview.showStep(step);
  diagram.solo = step;
  if (session.state) diagram.show(session.state);
  get("solo-note").hidden = step === null;
  refresh();
}

/** @param {import("./inspector.js").Action} action */
function act(action) {
  if (action === "solo") return solo(preview.solo === steps.step?.step ? null : steps.step?.step ?? null);
  if (action === "copy") return clipboard.copy(false);
  return steps[action]();
}

session.on("blocks", (blocks) => palette.fill(blocks));
session.on("state", showState);
session.on("settled", refresh);
session.on("notice", (text) => say(text));
session.on("clip", ({ size, count, live }) => {
  stylePanel.isFilm = live || count > 1;
  diagram.film = size.join(" × ");
  document.documentElement.style.setProperty("--aspect", size.join(" / "));
  if (session.state) diagram.show(session.state);
  refresh();
});
session.on("picture", ({ type, number, file }) => {
  if (type === PACKET.step) diagram.picture(number, file);
  if (type === PACKET.style) {
    start.picture(number, file);
    scenes.showLooks();
  }
});
const lost = new LostNotice("vidstyle design", [...["top", "film", "splitter", "diagram", "panel", "start"].map((id) => get(id))], "Unsaved changes are kept and offered there.");
session.on("connection", (loss) => {
  lost.show(loss);
  bar.lose(Boolean(loss));
  if (!loss) preview.watch().then(() => preview.refresh());
});

session.on("front", ({ reveal }) => {
  queue.reveals = reveal;
  queue.keep();
  lost.command = "vidstyle open";
  get("render").classList.add("strong");
  get("save").classList.remove("strong");
});

/** Renders the film: on the front page at once, under a new name. */
function render() {
  if (!document.body.classList.contains("front")) return dialogs.render();
  queue.open();
  return session.ask("render", { name: "", overwrite: false, frames: null });
}

const name = /** @type {HTMLInputElement} */ (get("name"));
name.addEventListener("change", () => session.edit("rename", { name: name.value.trim() }));
// The bar shows the same name as the tile; the field edits the name of the file.
name.addEventListener("focus", () => session.state && (name.value = session.state.name));
name.addEventListener("blur", () => session.state && (name.value = title(session.state.name)));
name.addEventListener("keydown", (event) => event.key === "Enter" && name.blur());
get("undo").addEventListener("click", () => again("undo"));
get("redo").addEventListener("click", () => again("redo"));
get("to-styles").addEventListener("click", () => start.show(true));
get("to-diagram").addEventListener("click", () => build(!document.body.classList.contains("building")));
get("save").addEventListener("click", () => dialogs.save());
get("save-as-new").addEventListener("click", () => dialogs.saveAs());
get("export").addEventListener("click", () => dialogs.export());
get("render").addEventListener("click", () => render());
get("help").addEventListener("click", () => help());
for (const item of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("[data-does]")))
  item.addEventListener("click", () => get(String(item.dataset.does)).click());
get("actions").addEventListener("click", () => get("actions").matches(":popover-open") && get("actions").hidePopover());
get("unsolo").addEventListener("click", () => solo(null));
for (const button of get("tabs").querySelectorAll("button"))
  button.addEventListener("click", () => showTab(/** @type {typeof tab} */ (button.value)));
get("tabs").addEventListener("keydown", (event) => {
  const shownTabs = [...get("tabs").querySelectorAll("button")].filter((button) => !button.hidden);
  const at = shownTabs.findIndex((button) => button.value === tab) + ({ ArrowLeft: -1, ArrowRight: 1 }[event.key] ?? NaN);
  shownTabs[at]?.click();
  shownTabs[at]?.focus();
});
// While the server is there, unsaved changes are kept as a draft.
addEventListener("beforeunload", (event) => session.state?.dirty && !session.connection.isOpen && event.preventDefault());
const keys = shortcuts({ session, queue, steps, diagram, preview, bar, dialogs, history, start, build, solo, render, help, scopes, scenes, again, clipboard });
listen(keys);

/** Shows the keys of the present screen. */
function help() {
  describe(start.isOpen ? START_KEYS : keys);
  return dialogs.help();
}
keepTabInDialogs();
switchTheme(get("theme"));
bar.show();
