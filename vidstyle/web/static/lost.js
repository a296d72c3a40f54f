// The notice of a lost connection, above everything else and away from the controls.

import { make } from "./elements.js";

/** Why a connection is lost, and what the user can do. @type {Record<import("./socket.js").Loss, (command: string) => string>} */
const TEXTS = {
  broken: () => "Connection to vidstyle lost. Trying again…",
  full: () => "Too many browsers show this page. Close one of them; this page tries again.",
  restarted: (command) => `vidstyle was started again and asks for its new address: open the one that “${command}” prints.`,
  stopped: (command) => `vidstyle has stopped. Start “${command}” again to continue.`,
};

/** Shows why the page does not respond, and disables its parts meanwhile. */
export class LostNotice {
  /**
   * @param {string} command the command that serves the page
   * @param {HTMLElement[]} parts the parts that need the server
   * @param {string} [kept] what happens to unsaved changes
   */
  constructor(command, parts, kept = "") {
    this.command = command;
    this.parts = parts;
    this.kept = kept;
    this.element = make("p", { className: "lost", popover: "manual" });
    this.element.setAttribute("role", "alert");
    document.body.append(this.element);
    for (const part of parts) part.classList.add("needs-server");
  }

  /** @param {import("./socket.js").Loss | null} loss null: connected */
  show(loss) {
    for (const part of this.parts) part.toggleAttribute("data-lost", loss !== null);
    if (!loss) {
      if (this.element.matches(":popover-open")) this.element.hidePopover();
      return;
    }
    const text = `${TEXTS[loss](this.command)} ${loss === "broken" || loss === "full" ? "" : this.kept}`.trim();
    if (this.element.textContent !== text) this.element.textContent = text;
    // A dialog that was opened later would cover it.
    if (this.element.matches(":popover-open")) this.element.hidePopover();
    this.element.showPopover();
  }
}
