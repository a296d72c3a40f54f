// Functions to find and create elements of a page.

/**
 * Returns the element with this id, which must exist.
 * @template {HTMLElement} [Kind=HTMLElement]
 * @param {string} id
 * @returns {Kind}
 */
export function get(id) {
  return /** @type {Kind} */ (document.getElementById(id));
}

/**
 * Creates an element with these properties and children.
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Partial<Omit<HTMLElementTagNameMap[Tag], "list">> & Object<string, any>} [properties]
 * @param {...(Node | string)} children
 * @returns {HTMLElementTagNameMap[Tag]}
 */
export function make(tag, properties = {}, ...children) {
  const made = document.createElement(tag);
  Object.assign(made, properties);
  made.append(...children);
  return made;
}

/** Marks a button as pressed or not. @param {Element | null | undefined} button @param {boolean} on */
export function press(button, on) {
  if (button?.getAttribute("aria-pressed") !== String(on)) button?.setAttribute("aria-pressed", String(on));
}

/** Changes the size of a canvas, which clears it, unless it has this size. @param {HTMLCanvasElement} canvas @param {number[]} size */
export function resize(canvas, [width, height]) {
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
}

/** Returns a function that has `draw` called at the next refresh of the screen, once. @param {() => void} draw */
export function oncePerFrame(draw) {
  let pending = false;
  return () => {
    if (!pending) requestAnimationFrame(() => ((pending = false), draw()));
    pending = true;
  };
}

/** Calls `follow` while a pointer is pressed on an element, wherever it moves. @param {HTMLElement} element @param {(event: PointerEvent) => void} follow @param {(event: PointerEvent) => boolean} [takes] */
export function followPointer(element, follow, takes = () => true) {
  element.addEventListener("pointerdown", (event) => {
    if (!takes(event)) return;
    element.setPointerCapture(event.pointerId);
    follow(event);
  });
  element.addEventListener("pointermove", (event) => element.hasPointerCapture(event.pointerId) && follow(event));
}

/** Saves what an address leads to, as a file with this name. @param {string} href @param {string} name */
export const saveAs = (href, name) => make("a", { href, download: name }).click();

/** Downloads a file. @param {Blob} blob @param {string} name */
export function download(blob, name) {
  const address = URL.createObjectURL(blob);
  saveAs(address, name);
  setTimeout(() => URL.revokeObjectURL(address), 60000);
}

/** Replaces underscores with spaces. @param {string} name */
export const words = (name) => name.replaceAll("_", " ");

/** First words of names that are written in another way. @type {Object<string, string>} */
const WRITTEN = { ascii: "ASCII", crt: "CRT", vhs: "VHS" };

/** Returns a name as words that start with a capital letter. @param {string} text */
export const title = (text) => words(text).replace(/^\w+/, (first) => WRITTEN[first] ?? first).replace(/^\w/, (letter) => letter.toUpperCase());

/** Returns a time as minutes and seconds. @param {number} seconds */
export const clock = (seconds) => `${Math.floor(seconds / 60)}:${String(Math.floor(seconds % 60)).padStart(2, "0")}`;

const SVG_NAMESPACE = "http://www.w3.org/2000/svg";

/** Icon outlines in a square of 16 units. @type {Object<string, string>} */
const ICONS = {
  undo: "M6 3 2.5 6.5 6 10M3 6.5h6.5a4 4 0 0 1 0 8H6",
  redo: "m10 3 3.5 3.5L10 10m3-3.5H6.5a4 4 0 0 0 0 8H10",
  play: "M4.5 2.5v11l9-5.5z",
  pause: "M5 2.5v11M11 2.5v11",
  next: "M3.5 3v10l6-5zM12.5 3v10",
  previous: "M12.5 3v10l-6-5zM3.5 3v10",
  loop: "M3 8V7a3 3 0 0 1 3-3h7m-2.5-2.5L13 4l-2.5 2.5M13 8v1a3 3 0 0 1-3 3H3m2.5 2.5L3 12l2.5-2.5",
  plus: "M8 3v10M3 8h10",
  mute: "M8 1.8v5.4M4.7 3.6a5.6 5.6 0 1 0 6.6 0",
  solo: "M1.5 8S4 3.5 8 3.5 14.5 8 14.5 8 12 12.5 8 12.5 1.5 8 1.5 8ZM8 10a2 2 0 1 0 0-4 2 2 0 0 0 0 4Z",
  copy: "M5.5 5.5h8v8h-8zM10.5 5.5v-3h-8v8h3",
  clipboard: "M5.5 3h-2v11h9V3h-2M5.5 2h5v2.5h-5zM6 8h4M6 11h4",
  remove: "M3 4.5h10M6.5 4.5V2.5h3v2M4.5 4.5l.7 9h5.6l.7-9",
  expand: "M2.5 6V2.5H6M10 2.5h3.5V6M13.5 10v3.5H10M6 13.5H2.5V10",
  rename: "M2.5 13.5 3.2 10.5 11 2.7l2.3 2.3-7.8 7.8zM9.5 4.2l2.3 2.3",
  pin: "M6 2.5h4l-.5 4.5 2.5 2H4l2.5-2zM8 9v5",
  result: "M2 3.5h12v9H2z",
  split: "M2 3.5h12v9H2zM8 2v12",
  side: "M1.5 4.5h6v7h-6zM8.5 4.5h6v7h-6z",
  theme: "M8 1.8a6.2 6.2 0 1 0 0 12.4zM8 1.8a6.2 6.2 0 0 1 0 12.4",
  hold: "M8 14.5A6.5 6.5 0 0 0 8 1.5zM8 14.5a6.5 6.5 0 0 1 0-13",
  diagram: "M1.5 6h4v4h-4zM10.5 2h4v4h-4zM10.5 10h4v4h-4zM5.5 8H8V4h2.5M8 8v4h2.5",
  help: "M6 6a2 2 0 1 1 3 1.7c-.7.4-1 .8-1 1.6m0 2.2v.1M8 14.5a6.5 6.5 0 1 0 0-13 6.5 6.5 0 0 0 0 13Z",
  styles: "M2 2.5h5v5H2zM9 2.5h5v5H9zM2 9h5v4.5H2zM9 9h5v4.5H9z",
  close: "m4 4 8 8m0-8-8 8",
  more: "M3 8h.1M8 8h.1M13 8h.1",
  fit: "M2.5 5.5v-3h3M10.5 2.5h3v3M13.5 10.5v3h-3M5.5 13.5h-3v-3M5.5 6h5v4h-5z",
  warning: "M8 2 1.5 13.5h13zM8 6.5v3.5M8 11.8v.1",
  star: "m8 1.8 1.9 4 4.3.6-3.1 3.1.7 4.4L8 11.8l-3.8 2.1.7-4.4L1.8 6.4l4.3-.6z",
  enlarge: "M7 12A5 5 0 1 0 7 2a5 5 0 0 0 0 10Zm3.7-1.3L14 14M7 5v4M5 7h4",
  camera: "M2 5h3l1-2h4l1 2h3v8H2zM8 11.5a2.5 2.5 0 1 0 0-5 2.5 2.5 0 0 0 0 5Z",
  panels: "M2 2h5v6H2zM9 2h5v3.5H9zM9 7.5h5V14H9zM2 10h5v4H2z",
  back: "M10.5 2.5 5 8l5.5 5.5",
  forward: "M5.5 2.5 11 8l-5.5 5.5",
  print: "M4.5 6V2.5h7V6M4.5 12h-2V6h11v6h-2M4.5 9.5h7v4h-7z",
  queue: "M2.5 3.5h11M2.5 8h11M2.5 12.5h6M11 10.5v4l3-2z",
  sliders: "M2 4.5h6m3.5 0H14M2 11.5h2.5m3.5 0h6M9.7 6.2a1.7 1.7 0 1 0 0-3.4 1.7 1.7 0 0 0 0 3.4ZM6.2 13.2a1.7 1.7 0 1 0 0-3.4 1.7 1.7 0 0 0 0 3.4Z",
  save: "M2.5 2.5h8.5l2.5 2.5v8.5h-11zM5 2.5v3.5h5V2.5M4.5 13.5v-4h7v4",
  export: "M8 10V2M5 5l3-3 3 3M2.5 9.5v4h11v-4",
  drop: "M8 2v8M5 7l3 3 3-3M2.5 9.5v4h11v-4",
  scopes: "M2 13.5h12M3.5 13V8.5M6.5 13V4M9.5 13V6.5M12.5 13v-3",
  restore: "M3 3v4h4M3.5 7A5.5 5.5 0 1 1 2.5 9",
};

/**
 * Creates an icon.
 * @param {keyof typeof ICONS} name
 */
export function icon(name) {
  const drawing = makeSvg("svg", { viewBox: "0 0 16 16", "aria-hidden": "true" });
  drawing.append(makeSvg("path", { d: ICONS[name] }));
  return drawing;
}

/**
 * Creates an SVG element with these attributes.
 * @param {string} tag
 * @param {Object<string, string | number>} attributes
 */
export function makeSvg(tag, attributes) {
  const made = document.createElementNS(SVG_NAMESPACE, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, String(value));
  return made;
}
