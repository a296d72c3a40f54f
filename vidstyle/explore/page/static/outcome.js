// The line of the lightbox that says what an action has done, and where the file is that it has written.

import { get, icon, make } from "./elements.js";

/** Returns a link that looks like a button. @param {string} href @param {string} text @param {Partial<HTMLAnchorElement>} options */
const link = (href, text, options) => make("a", { href, className: "button", textContent: text, ...options });

/** Shows what an action on a look does and has done. */
export class Outcome {
  /** @param {(text: string) => void} say shows a message while no look is open @param {(file: string) => void} reveal shows a file in its folder */
  constructor(say, reveal) {
    this.say = say;
    this.reveal = reveal;
    this.line = get("outcome");
  }

  /** @param {string} text @param {string} [kind] "alarm" or "spinning" */
  report(text, kind = "") {
    if (!this.line.closest("dialog")?.open) this.say(text);
    this.line.textContent = text;
    this.line.className = `quiet ${kind}`;
    if (text && kind !== "spinning") this.line.append(make("button", { className: "plain", title: "Close", ariaLabel: "Close", onclick: () => this.report("") }, icon("close")));
  }

  /** Reports a file that was written, with its folder. @param {string} done @param {string} file @param {{canReveal: boolean, address?: string}} options whether it can be shown in its folder, and where the server has it */
  reportFile(done, file, { canReveal, address }) {
    const [, folder, name] = file.match(/^(.*?)[\\/]?([^\\/]*)$/) ?? [];
    this.report(`${done} as ${name}`);
    const place = make("span", { className: "quiet", textContent: folder });
    const copy = make("button", { textContent: "Copy path", onclick: () => this.#copy(file, copy, place) });
    const reveal = make("button", { textContent: "Show in folder", hidden: !canReveal, onclick: () => this.reveal(file) });
    const links = address ? [link(address, "Show", { target: "_blank" }), link(address, "Download", { download: name })] : [];
    this.line.append(place, make("span", { className: "files" }, ...links, reveal, copy));
    this.line.scrollIntoView({ block: "nearest" });
  }

  /** @param {string} path @param {HTMLElement} button @param {HTMLElement} place shows the selected path if the browser cannot copy */
  async #copy(path, button, place) {
    try {
      await navigator.clipboard.writeText(path);
      button.textContent = "Copied";
    } catch {
      place.textContent = path;
      getSelection()?.selectAllChildren(place);
    }
  }
}
