// The page of an exported style. `vidstyle.export.page` joins it with the modules that it imports.

import { announce } from "./announce.js";
import { get, title } from "./elements.js";
import { missing, Runner } from "./runner.js";
import { loadPicture } from "./source.js";
import { switchTheme } from "./theme.js";
import { Viewer } from "./viewer.js";

/** @typedef {import("./viewer.js").StyleData} StyleData */

/** Part of the example that shows the original. */
const EXAMPLE_SPLIT = 0.4;

/** Puts the shared texts and textures into the plans. */
function readData() {
  /** @type {StyleData & {shaders: string[], textures: import("./runner.js").Plan["textures"]}} */
  const data = JSON.parse(get("data").textContent ?? "");
  for (const { plan } of data.plans) {
    plan.textures = data.textures;
    plan.shaders = plan.shaders.map((number) => data.shaders[Number(number)]);
  }
  return data;
}

async function start() {
  const lacks = missing();
  if (lacks.length) return refuse(lacks);
  const options = new URLSearchParams(location.search);
  document.body.classList.toggle("bare", options.has("bare"));
  const viewer = new Viewer(new Runner({ onrestored: () => viewer.redraw() }));
  const data = readData();
  for (const heading of document.querySelectorAll("h1")) heading.textContent = title(data.name);
  const wanted = data.plans.find(({ side }) => String(side) === options.get("side"));
  const compiled = viewer.show(data, wanted?.side);
  if (options.has("camera")) await viewer.source.openCamera(options.get("camera") ?? "");
  else await showExample(viewer);
  document.body.classList.remove("starting");
  await compiled;
}

/** Says in place of the invitation what the browser lacks. @param {string[]} lacks */
function refuse(lacks) {
  switchTheme(get("theme"));
  document.body.classList.replace("starting", "refused");
  get("invitation").textContent = `This style cannot be shown here: ${lacks.join("; ")}. Another browser may show it, or “vidstyle render” on a computer.`;
}

/** Shows what the style does, above the invitation to open a file. @param {Viewer} viewer */
async function showExample(viewer) {
  const [picture, restyled] = await Promise.all(["example", "restyled"].map((id) => loadPicture(/** @type {HTMLImageElement} */ (get(id)).src)));
  if (viewer.source.picture) return; // opened meanwhile
  viewer.source.show(picture);
  viewer.prepare(restyled);
  viewer.compare(EXAMPLE_SPLIT);
  document.body.classList.add("empty", "example");
}

start().catch((error) => {
  document.body.classList.remove("starting");
  announce(get("message"), error.message, { seconds: 0 });
});
