// The bar below the picture: playback, before and after, zoom, and the renderer.

import { clock, get, icon, press } from "./elements.js";
import { switchOriginal } from "./original_button.js";
import { rove } from "./roving.js";

/** @typedef {import("./preview.js").Preview} Preview */

/** Shows the state of a `Preview` and controls it. */
export class Bar {
  /** @param {Preview} preview @param {(text: string) => void} say */
  constructor(preview, say) {
    this.preview = preview;
    this.say = say;
    this.place = /** @type {HTMLInputElement} */ (get("place"));
    this.place.addEventListener("input", () => preview.player.show(Number(this.place.value)));
    get("play").addEventListener("click", () => preview.player.toggle());
    get("previous").addEventListener("click", () => preview.player.step(-1));
    get("next").addEventListener("click", () => preview.player.step(1));
    get("loop").addEventListener("click", () => this.mark());
    for (const button of get("modes").querySelectorAll("button"))
      button.addEventListener("click", () => preview.view.setMode(/** @type {import("./picture.js").Mode} */ (button.value)));
    for (const button of get("zooms").querySelectorAll("button"))
      button.addEventListener("click", () => preview.view.setZoom(Number(button.value) || null));
    switchOriginal(get("hold"), () => preview.view.holding, (on) => preview.view.hold(on));
    for (const group of ["modes", "zooms"]) rove(get(group), "button");
    this.against = /** @type {HTMLSelectElement} */ (get("against"));
    this.against.addEventListener("change", () => preview.compareWith(/** @type {"source" | "opened"} */ (this.against.value)));
    this.#menu();
  }

  #menu() {
    const where = /** @type {HTMLSelectElement} */ (get("where"));
    const side = /** @type {HTMLSelectElement} */ (get("side"));
    const { restyler } = this.preview;
    const page = new Option(restyler.runner ? "this browser" : `this browser (${restyler.reason})`, "page");
    page.disabled = !restyler.runner;
    where.replaceChildren(page, new Option("vidstyle, on this computer", "server"));
    const choose = () => {
      this.preview.chosenSide = Number(side.value);
      return this.preview.renderIn(/** @type {import("./preview.js").Where} */ (where.value), this.preview.chosenSide || this.preview.side).then(() => this.show());
    };
    where.addEventListener("change", choose);
    side.addEventListener("change", choose);
    get("check").addEventListener("click", () => this.check());
    get("steady").addEventListener("click", () => this.steady());
    const menu = get("view-menu");
    addEventListener("resize", () => menu.hidePopover());
    get("to-scenes").addEventListener("click", () => menu.hidePopover());
    menu.addEventListener("toggle", (event) => {
      if (/** @type {ToggleEvent} */ (event).newState !== "open") return;
      const { right, top } = get("view").getBoundingClientRect();
      Object.assign(menu.style, { left: `${Math.max(8, right - menu.offsetWidth)}px`, top: `${Math.max(8, top - menu.offsetHeight - 8)}px` });
    });
  }

  async check() {
    const found = await this.preview.check();
    if (!found) return;
    const share = found.share ? `${(100 * found.share).toPrecision(2)} % of the colour values differ by more than one level` : "no colour value differs by more than one level";
    get("checked").textContent = `Preview and rendered result: ${share}; the largest difference is ${found.largest} of 255 levels.`;
    this.say(String(get("checked").textContent));
  }

  async steady() {
    await this.preview.player.pause();
    this.say("Preparing one second without flicker…");
    await this.preview.session.ask("steady");
  }

  /** Sets the start of the loop, then its end, then clears it. */
  mark() {
    const { player } = this.preview;
    if (player.range && player.range[1] < player.clip.count - 1) player.setRange(null);
    else if (player.range) player.setRange([Math.min(player.range[0], player.number), Math.max(player.range[0] + 1, player.number)]);
    else player.setRange([player.number, player.clip.count - 1]);
  }

  show() {
    const { player, view, where, restyler } = this.preview;
    const { clip, number, range } = player;
    get("film").hidden = get("to-scenes").hidden = !player.isFilm;
    this.place.max = String(Math.max(1, clip.count - 1));
    this.place.value = String(number);
    const part = (/** @type {number} */ at) => String(at / Math.max(1, clip.count - 1));
    const track = /** @type {HTMLElement} */ (this.place.parentElement);
    for (const [name, value] of [["--part", part(number)], ["--from", part(range?.[0] ?? 0)], ["--to", part(range?.[1] ?? clip.count - 1)]])
      track.style.setProperty(name, value);
    const seconds = player.time(number);
    get("time").textContent = `${Math.floor(seconds / 60)}:${(seconds % 60).toFixed(2).padStart(5, "0")} / ${clock(clip.count / clip.fps)}`;
    get("time").title = `Frame ${number + 1} of ${clip.count}`;
    this.place.setAttribute("aria-valuetext", `frame ${number + 1} of ${clip.count}`);
    get("play").replaceChildren(icon(player.playing ? "pause" : "play"));
    get("play").setAttribute("aria-label", player.playing ? "Pause" : "Play");
    press(get("loop"), range !== null);
    for (const button of get("modes").querySelectorAll("button")) press(button, button.value === view.mode);
    for (const button of get("zooms").querySelectorAll("button")) press(button, (Number(button.value) || null) === view.zoom);
    const isEdited = (this.preview.session.state?.history.length ?? 0) > 1;
    this.against.hidden = view.mode === "result" || !isEdited;
    this.against.value = this.preview.against;
    this.#placeZoom();
    press(get("hold"), view.holding);
    this.#placeLabels();
    const own = Math.min(...clip.size);
    const { sides, chosenSide } = this.preview;
    const menu = /** @type {HTMLSelectElement} */ (get("side"));
    if (menu.options.length !== sides.length + 1 || menu.options[sides.length]?.value !== String(sides.at(-1)))
      menu.replaceChildren(new Option("final size", "0"), ...sides.map((each) => new Option(each === own ? `${each} pixels high (as the film)` : `${each} pixels high`, String(each))));
    menu.value = String(chosenSide && sides.reduce((best, each) => (each <= chosenSide ? each : best), sides[0]));
    /** @type {HTMLSelectElement} */ (get("where")).value = where;
    get("who").textContent = where === "server" ? "The frames come from vidstyle, exactly as it renders them." : restyler.isFast ? "With the graphics card" : "Without a graphics card";
    get("device").textContent = where === "page" ? restyler.runner ? `(${restyler.runner.device}).` : "" : "";
  }

  /** Shows whether vidstyle answers. @param {boolean} on */
  lose(on) {
    get("view").classList.toggle("stopped", on);
    get("state").textContent = on ? "Stopped" : "View";
  }

  /** Shows a zoom that has no button. */
  #placeZoom() {
    const { zoom } = this.preview.view;
    const output = get("zoom-now");
    output.hidden = zoom === null || get("zooms").querySelector("[aria-pressed=true]") !== null;
    output.textContent = zoom === null ? "" : `${Math.round(100 * zoom)} %`;
  }

  /** Positions the labels of both pictures, and the divider. */
  #placeLabels() {
    const { view } = this.preview;
    const [first, second] = view.panes;
    const [before, after] = ["before", "after"].map(get);
    const split = view.mode === "split" && !view.holding;
    before.hidden = !(split || second || view.holding);
    after.hidden = !(split || second) || !view.result;
    before.textContent = view.opened && (split || second) ? "As opened" : "Original";
    const box = view.boxIn(first);
    const top = Math.max(first.y, box.y) + 10;
    Object.assign(before.style, { left: `${Math.max(first.x, box.x) + 10}px`, top: `${top}px` });
    const other = second ? view.boxIn(second) : box;
    const right = second ? Math.max(second.x, other.x) + 10 : Math.min(first.x + first.width, box.x + box.width) - 10 - after.offsetWidth;
    Object.assign(after.style, { left: `${right}px`, top: `${second ? Math.max(second.y, other.y) + 10 : top}px` });
    // The tag is on the picture, even if the picture does not fill the screen.
    const shown = second ? other : box;
    const { clientWidth, clientHeight } = get("screen");
    Object.assign(get("draft-note").style, {
      right: `${Math.max(0, clientWidth - shown.x - shown.width) + 10}px`, bottom: `${Math.max(0, clientHeight - shown.y - shown.height) + 10}px`,
    });
    view.divider.place();
    if (view.holding) get("divider").hidden = true;
  }
}
