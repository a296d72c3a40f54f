// The list of unsaved changes: looks that were changed and left without saving.

import { openDialog } from "./dialogs.js";
import { get, make, title } from "./elements.js";

/** @typedef {{name: string, when: string, picture: string, folder: string, here: boolean}} Draft */

/** Offers drafts behind buttons that show their number. */
export class DraftList {
  /**
   * @param {import("./session.js").Session} session
   * @param {(place: number) => void} restore opens a draft by its place in the list
   */
  constructor(session, restore) {
    this.session = session;
    this.restore = restore;
    this.dialog = /** @type {HTMLDialogElement} */ (get("drafts-dialog"));
    session.on("drafts", (drafts) => this.#show(drafts));
    for (const button of this.#buttons) {
      button.append(make("span"));
      button.addEventListener("click", () => openDialog("drafts-dialog"));
    }
  }

  get #buttons() {
    return /** @type {NodeListOf<HTMLButtonElement>} */ (document.querySelectorAll(".to-drafts"));
  }

  /** @param {Draft[]} drafts newest first */
  #show(drafts) {
    for (const button of this.#buttons) {
      // Next to the looks, nobody would know changes from other folders; the menu lists them.
      button.hidden = !(button.closest("#looks") ? drafts.some(({ here }) => here) : drafts.length);
      /** @type {HTMLElement} */ (button.lastElementChild).textContent = `Unsaved changes (${drafts.length})`;
    }
    get("drafts").replaceChildren(...drafts.map((draft, place) => this.#entry(draft, place)));
    if (!drafts.length) this.dialog.close();
  }

  /** @param {Draft} draft @param {number} place */
  #entry({ name, when, picture, folder, here }, place) {
    const time = new Date(when).toLocaleString("en-GB", { day: "numeric", month: "short", hour: "2-digit", minute: "2-digit" });
    const facts = [picture && `on ${picture}`, !here && folder && `in the folder ${folder}`, time];
    const restore = make("button", { type: "button", textContent: "Restore" });
    restore.addEventListener("click", () => {
      this.dialog.close();
      this.restore(place);
    });
    const discard = make("button", { type: "button", textContent: "Discard", onclick: () => this.session.ask("draft", { accept: false, place }) });
    return make("li", {}, make("span", {}, make("b", { textContent: title(name) }), make("span", { className: "quiet", textContent: ` ${facts.filter(Boolean).join(", ")}` })), restore, discard);
  }
}
