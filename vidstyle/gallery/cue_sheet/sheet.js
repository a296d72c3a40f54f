// The page of a cue sheet. `vidstyle.gallery.cue_sheet` joins it with the modules that it imports.

import { CueEditor } from "./cue_editor.js";
import { download, get } from "./elements.js";
import { switchTheme } from "./theme.js";

/** @type {import("./cue_text.js").Sheet} */
const sheet = JSON.parse(get("data").textContent ?? "");
const editor = new CueEditor(sheet);
const answer = /** @type {HTMLElement} */ (document.querySelector("footer output"));

/** Gives the text of the cue file to `use`, or says what is wrong. @param {(text: string) => Promise<string> | string} use */
async function withText(use) {
  answer.textContent = editor.mistake || await use(editor.text);
}

/** @type {HTMLElement} */ (document.querySelector(".save")).addEventListener("click", () => withText((text) => {
  download(new Blob([text], { type: "application/toml" }), sheet.file);
  return `Saved as ${sheet.file} in your downloads: vidstyle render FILM OUTPUT --cues ${sheet.file}`;
}));
/** @type {HTMLElement} */ (document.querySelector(".copy")).addEventListener("click", () => withText(async (text) => {
  await navigator.clipboard.writeText(text);
  return "The text of the cue file is in the clipboard.";
}));
addEventListener("keydown", (event) => {
  const step = { z: -1, y: 1 }[event.key.toLowerCase()], typing = event.target instanceof HTMLInputElement && event.target.type === "number";
  if (!(event.ctrlKey || event.metaKey) || !step || typing) return;
  event.preventDefault();
  editor.undo(event.shiftKey ? 1 : /** @type {-1 | 1} */ (step));
});
switchTheme(get("theme"));
