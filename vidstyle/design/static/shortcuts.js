// The keyboard shortcuts of the designer.

import { get } from "./elements.js";
import { SHARED_KEYS } from "./shared_keys.js";

/**
 * The parts of the page.
 * @typedef {object} Parts
 * @property {import("./session.js").Session} session
 * @property {import("./queue.js").Queue} queue
 * @property {import("./steps.js").Steps} steps
 * @property {import("./diagram.js").Diagram} diagram
 * @property {import("./preview.js").Preview} preview
 * @property {import("./bar.js").Bar} bar
 * @property {import("./dialogs.js").Dialogs} dialogs
 * @property {import("./history.js").History} history
 * @property {import("./start.js").Start} start
 * @property {(on: boolean) => void} build
 * @property {(step: number | null) => unknown} solo
 * @property {() => unknown} render
 * @property {() => unknown} help
 * @property {import("./scopes.js").Scopes} scopes
 * @property {import("./clipboard.js").Clipboard} clipboard
 * @property {import("./scenes.js").Scenes} scenes
 * @property {(which: "undo" | "redo") => void} again
 */

/**
 * @param {Parts} parts
 * @returns {import("./keys.js").Shortcut[]}
 */
export function shortcuts({ queue, steps, diagram, preview, bar, dialogs, history, start, build, solo, render, help, scopes, scenes, again, clipboard }) {
  const { view, player } = preview;
  const isBuilding = () => document.body.classList.contains("building") && !start.isOpen;
  /** Returns the focused card, else the selected one. */
  const focused = () => {
    const name = /** @type {HTMLElement | null} */ (document.activeElement?.closest("[data-card]"))?.dataset.card;
    if (name === undefined) return steps.selected ?? "source";
    return /** @type {import("./layout.js").CardName} */ (Number.isNaN(Number(name)) ? name : Number(name));
  };
  const near = () => document.activeElement?.closest("[data-card]")?.getBoundingClientRect() ?? null;
  /** @param {() => unknown} run */
  const onStep = (run) => () => {
    if (!isBuilding()) return false;
    if (steps.selected !== focused()) steps.select(focused());
    return run();
  };
  /** @param {KeyboardEvent} event */
  const walk = (event) => {
    const card = document.activeElement?.closest("[data-card]");
    if (!isBuilding() || (!card && document.activeElement !== document.body)) return false;
    steps.select(diagram.neighbour(focused(), event.key));
  };
  const toValues = () => {
    // Sliders first: a key that is meant for one would change a list.
    const inside = "#panel [role=tabpanel]:not([hidden]) .values";
    const first = document.querySelector(`${inside} input[type=range]`) ?? document.querySelector(`${inside} :is(input:not([type=number]), select)`);
    /** @type {HTMLElement | null} */ (first)?.focus();
  };
  get("skip").addEventListener("click", toValues);
  const inspect = () => {
    if (!document.activeElement?.closest(".card")) return false;
    steps.select(focused());
    toValues();
  };
  const leave = () => {
    if (document.querySelector('[popover=""]:popover-open')) return false; // the browser closes it
    if (start.isOpen) return start.leave();
    if (preview.solo !== null && !document.activeElement?.closest("#panel")) return solo(null);
    if (!isBuilding()) return false;
    diagram.focus(focused());
  };
  /** @param {() => unknown} run */
  const open = (run) => () => (start.isOpen ? false : run());
  const modes = /** @type {const} */ (["result", "split", "side"]);
  const zooms = [null, 1, 2];
  return [
    { group: "Diagram", keys: ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"], help: "Move from step to step", run: walk },
    { keys: ["Enter"], help: "Edit the step", run: inspect },
    { keys: ["Escape"], help: "Return to the diagram", run: leave, typing: true },
    { keys: ["a"], help: "Add a step after this one", run: onStep(() => steps.addAfter(near())) },
    { keys: ["Delete", "Backspace"], help: "Remove the step", run: onStep(() => steps.remove()) },
    { keys: ["m"], help: "Mute or unmute the step", run: onStep(() => steps.mute()) },
    { keys: ["o"], help: "Solo: show the output of the step", run: onStep(() => solo(preview.solo === steps.step?.step ? null : steps.step?.step ?? null)) },
    { keys: ["d"], help: "Duplicate the step", run: onStep(() => steps.duplicate()) },
    { keys: ["Ctrl+c"], help: "Copy the step; Ctrl V pastes it after the selected one", run: () => !String(getSelection()) && onStep(() => void clipboard.copy(false))() },
    { keys: ["Ctrl+Shift+c"], help: "Copy all steps of its row: Prepare, Colour or Lines", run: onStep(() => void clipboard.copy(true)) },
    { keys: ["e"], help: "Replace a step that is made of steps with these", run: onStep(() => steps.expand()) },
    { keys: ["Alt+ArrowLeft", "Alt+ArrowRight", "Alt+ArrowUp", "Alt+ArrowDown"], help: "Move the step within its row or to another", run: (event) => onStep(() => steps.shift(event.key))() },
    { keys: ["g"], help: "Show or hide the diagram", run: open(() => build(!isBuilding())) },
    { group: "Edits", keys: ["Ctrl+z"], help: "Undo", run: () => again("undo") },
    { keys: ["Ctrl+y", "Ctrl+Shift+z"], help: "Redo", run: () => again("redo") },
    { keys: ["Shift+1", "Shift+2"], help: "Store snapshot A or B", run: (event) => history.keep(event.code === "Digit1" ? "a" : "b") },
    { keys: ["1", "2"], help: "View snapshot A or B", run: (event) => history.restore(event.key === "1" ? "a" : "b") },
    { keys: ["Ctrl+s", SHARED_KEYS.save], help: "Save the style", run: open(() => dialogs.save()), typing: true },
    { keys: ["Ctrl+Shift+s"], help: "Save under another name", run: open(() => dialogs.saveAs()), typing: true },
    { keys: ["Ctrl+e"], help: "Export", run: open(() => dialogs.export()), typing: true },
    { keys: ["Ctrl+Enter"], help: "Render in this style", run: open(render), typing: true },
    { keys: ["q"], help: "Go to the renders: play or download finished films", run: () => queue.enter() },
    { keys: ["Ctrl+o"], help: "Show all styles", run: () => start.show(true), typing: true },
    { group: "Values", keys: ["v"], help: "Go to the values", run: open(toValues) },
    { keys: ["ArrowLeft", "ArrowRight", "PageUp", "PageDown"], help: "Change the value", inControl: true, run: () => {} },
    { keys: ["Enter"], help: "Type the value; Enter or Escape returns to the slider", inControl: true, run: () => {} },
    { keys: ["Delete", "Backspace"], help: "Reset the value", inControl: true, run: () => {} },
    { keys: ["F2"], help: "Rename the value", inControl: true, run: () => {} },
    { group: "Picture", keys: [" ", SHARED_KEYS.play], help: "Play or pause", run: open(() => player.toggle()) },
    { keys: [",", "."], help: "Previous or next frame", run: (event) => player.step(event.key === "," ? -1 : 1) },
    { keys: ["l"], help: "Set the start of the loop, then its end, then clear it", run: () => bar.mark() },
    { keys: ["\\", SHARED_KEYS.original], help: "Hold to see the original", run: () => view.hold(true), end: () => view.hold(false) },
    { keys: [SHARED_KEYS.compare], help: "Switch between result, split and side by side", run: () => view.setMode(modes[(modes.indexOf(view.mode) + 1) % 3]) },
    { keys: [SHARED_KEYS.zoom], help: "Switch between fit, 100 % and 200 %", run: () => view.setZoom(zooms[(zooms.indexOf(view.zoom) + 1) % 3]) },
    { keys: ["Shift+ArrowLeft", "Shift+ArrowRight", "Shift+ArrowUp", "Shift+ArrowDown"], help: "Pan the picture", run: (event) => view.pan(...PAN_STEPS[event.key]) },
    { keys: ["t"], help: "Show or hide the scenes: styles over time", run: open(() => scenes.toggle()) },
    { keys: ["h"], help: "Show or hide the scopes", run: open(() => scopes.toggle()) },
    { keys: ["k"], help: "Measure how far the preview differs from the rendered result", run: () => bar.check() },
    { keys: [SHARED_KEYS.help], help: "Show this list", run: () => help() },
  ];
}

/** Distances in CSS pixels by arrow key. @type {Object<string, [number, number]>} */
const PAN_STEPS = { ArrowLeft: [60, 0], ArrowRight: [-60, 0], ArrowUp: [0, 60], ArrowDown: [0, -60] };
