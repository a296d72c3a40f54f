// A page of all components that the pages share, in each state, for tests and for looking at.

import { announce } from "./announce.js";
import { control } from "./controls.js";
import { get, icon, make, press } from "./elements.js";
import { switchTheme } from "./theme.js";

/** A value of each kind of control, at both ends and between them. @type {[Object<string, any>, any][]} */
const VALUES = [
  [{ name: "radius", label: "Low end", kind: "slider", low: 1, high: 8, unit: "px" }, 1],
  [{ name: "radius", label: "In between", kind: "slider", low: 1, high: 8, unit: "px" }, 4.5],
  [{ name: "levels", label: "High end, whole numbers", kind: "slider", low: 2, high: 32, whole: true }, 32],
  [{ name: "height", label: "Not set", kind: "slider", low: 16, high: 4096, unit: "px" }, null],
  [{ name: "edges", label: "On", kind: "switch" }, true],
  [{ name: "edges", label: "Off", kind: "switch" }, false],
  [{ name: "ink", label: "A colour with quite a long name that needs more than a line", kind: "color" }, "#c8460a"],
  [{ name: "mode", label: "A choice", kind: "choice", options: ["", "grain_extract", "multiply"] }, "grain_extract"],
  [{ name: "tiles", label: "An option that is not listed", kind: "choice", options: ["letters"] }, "mine.png"],
];

VALUES.forEach(([entry, value], number) => {
  const id = `value-${number}`;
  const shown = control(/** @type {any} */ (entry), id, (next) => (get("message").textContent = `${entry.label}: ${next}`));
  shown.show(value);
  const inline = make("div", { className: "value number" }, ...shown.inline);
  get("values").append(make("div", { className: "control" }, make("label", { htmlFor: id, textContent: entry.label }), inline, ...(shown.below ?? [])));
});
for (const [text, properties, pressed] of /** @type {[string, object, boolean | null][]} */ ([
  ["Plain", { className: "plain" }, null], ["Usual", {}, null], ["Strong", { className: "strong" }, null],
  ["Disabled", { disabled: true }, null], ["Pressed", {}, true], ["Not pressed", {}, false],
])) {
  const button = make("button", { type: "button", ...properties }, icon("play"), make("span", { textContent: text }));
  if (pressed !== null) press(button, pressed);
  get("buttons").append(button);
}
switchTheme(get("theme"));
announce(get("message"), "A message", { seconds: 0 });
announce(get("alarm"), "An error", { alarm: true, seconds: 0 });
document.body.dataset.ready = "";
