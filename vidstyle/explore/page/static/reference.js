// A picture whose look the next nine resemble: chosen or dropped.

import { get } from "./elements.js";

/** Maximum size of a reference picture; the server accepts no larger ones. */
const MAX_REFERENCE_BYTES = 2 ** 28;

/** Takes a picture, and shows the one that was taken last. */
export class Reference {
  #input = /** @type {HTMLInputElement} */ (get("reference-file"));

  /**
   * @param {(file: File) => void} onmatch shows the styles that are most like a picture
   * @param {(text: string) => void} say
   */
  constructor(onmatch, say) {
    this.onmatch = onmatch;
    this.say = say;
    get("match").onclick = () => this.choose();
    this.#input.onchange = () => {
      const [file] = this.#input.files ?? [];
      if (file) this.#take(file);
      this.#input.value = "";
    };
    for (const kind of /** @type {const} */ (["dragover", "dragleave", "drop"])) addEventListener(kind, (event) => this.#drag(event));
  }

  /** Opens the browser's dialog to choose a picture. */
  choose() {
    this.#input.click();
  }

  /** @param {number} count of pictures so far */
  show(count) {
    get("reference").hidden = !count;
    if (count) /** @type {HTMLImageElement} */ (get("reference-picture")).src = `reference.jpg?number=${count - 1}`;
  }

  /** @param {File} file */
  #take(file) {
    if (!file.size) return this.say(`${file.name}: the file is empty.`);
    if (file.size > MAX_REFERENCE_BYTES) return this.say(`${file.name}: too large to upload; choose a smaller copy.`);
    this.onmatch(file);
  }

  /** @param {DragEvent} event */
  #drag(event) {
    if (!event.dataTransfer?.types.includes("Files")) return;
    event.preventDefault();
    document.body.classList.toggle("over", event.type === "dragover");
    if (event.type === "drop" && event.dataTransfer.files[0]) this.#take(event.dataTransfer.files[0]);
  }
}
