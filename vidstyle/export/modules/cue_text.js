// The cues of a sheet as the text of a cue file.

/**
 * @typedef {{ start: string, clock: string, still: string }} Scene
 * @typedef {{ scene?: number, time?: number, style?: string, values?: Record<string, any>, transition?: string,
 *   seconds?: number, curve?: string }} CueTable a cue as in the file
 * @typedef {{ picture: string, entries: any[], variants: Record<string, Record<string, any>> }} StyleInfo
 * @typedef {{ file: string, rate: string | null, end: string, scenes: Scene[], cues: CueTable[],
 *   styles: Record<string, StyleInfo>, transitions: string[], curves: string[] }} Sheet
 */

/**
 * A cue on the page.
 * @typedef {object} Cue
 * @property {number} scene number of the scene that it lies in, from 0 on
 * @property {number | null} time in seconds; null: where the scene begins
 * @property {string} style without its variant; "": as in the cue before
 * @property {string} variant
 * @property {Record<string, any>} values that are set here
 * @property {string} transition
 * @property {number} seconds
 * @property {string} curve
 */

/** Returns a cue of a scene that changes nothing. @param {number} scene @param {number | null} [time] @returns {Cue} */
export function emptyCue(scene, time = null) {
  return { scene, time, style: "", variant: "", values: {}, transition: "cut", seconds: 0, curve: "hold" };
}

/** Returns the time of a cue in seconds. @param {Sheet} sheet @param {Cue} cue */
export const timeOf = (sheet, cue) => cue.time ?? Number(sheet.scenes[cue.scene]?.start);

/** Returns the cues of the file, and one for each other scene. @param {Sheet} sheet */
export const firstCues = (sheet) => withAllScenes(sheet, sheet.cues.map((table) => fromTable(sheet, table)));

/** Returns the cues, and one for each scene that has none. @param {Sheet} sheet @param {Cue[]} cues @returns {Cue[]} */
function withAllScenes(sheet, cues) {
  const free = sheet.scenes.map((_, scene) => scene).filter((scene) => !cues.some((cue) => cue.scene === scene && cue.time === null));
  return inOrder(sheet, [...cues, ...free.map((scene) => emptyCue(scene))]);
}

/** The number of the scene at a time. @param {Sheet} sheet @param {number} time */
export const sceneAt = (sheet, time) => Math.max(0, sheet.scenes.findLastIndex(({ start }) => Number(start) <= time));

/**
 * Moves a cue to a time, or to the start of a scene that is near; returns all cues.
 * @param {Sheet} sheet
 * @param {Cue[]} cues
 * @param {Cue} cue
 * @param {number} time
 * @param {number} snap seconds that are near
 */
export function moved(sheet, cues, cue, time, snap) {
  const near = sheet.scenes.findIndex(({ start }) => Math.abs(Number(start) - time) <= Math.max(snap, 0.0005));
  cue.time = near < 0 ? Number(time.toFixed(3)) : null;
  cue.scene = near < 0 ? sceneAt(sheet, time) : near;
  return withAllScenes(sheet, cues.filter((each) => each === cue || !isEmpty(each)));
}

/** Returns cues in the order of their times. @param {Sheet} sheet @param {Cue[]} cues */
export const inOrder = (sheet, cues) => [...cues].sort((one, other) => timeOf(sheet, one) - timeOf(sheet, other));

/** @param {Sheet} sheet @param {CueTable} table @returns {Cue} */
function fromTable(sheet, table) {
  const name = table.style ?? "";
  const style = Object.keys(sheet.styles).find((known) => name === known || name.startsWith(`${known}:`)) ?? "";
  return {
    ...emptyCue(table.scene === undefined ? sceneAt(sheet, table.time ?? 0) : table.scene - 1, table.time ?? null),
    style, variant: name.slice(style.length + 1), values: { ...table.values },
    transition: table.transition ?? (table.seconds ? "fade" : "cut"), seconds: table.seconds ?? 0, curve: table.curve ?? "hold",
  };
}

/** Whether a cue leaves everything as before. @param {Cue} cue */
export const isEmpty = (cue) => !cue.style && cue.transition === "cut" && cue.curve === "hold" && !Object.keys(cue.values).length;

/** Returns the text of the file. @param {Sheet} sheet @param {Cue[]} cues */
export function cueFile(sheet, cues) {
  const lines = [
    `# The styles of a film over time: vidstyle render FILM OUTPUT --cues ${sheet.file}`, "format = 1",
    ...(sheet.rate === null ? [] : [`rate = ${sheet.rate}`]),
    `scenes = [${sheet.scenes.map(({ start }) => start).join(", ")}]`,
  ];
  const used = cues.filter((cue) => !isEmpty(cue));
  for (const cue of used) {
    const values = Object.entries(cue.values).map(([path, value]) => `${JSON.stringify(path)} = ${JSON.stringify(value)}`);
    lines.push("", "[[cue]]", cue.time === null ? `scene = ${cue.scene + 1}` : `time = ${cue.time}`);
    if (cue.style) lines.push(`style = ${JSON.stringify(cue.variant ? `${cue.style}:${cue.variant}` : cue.style)}`);
    if (values.length) lines.push(`values = { ${values.join(", ")} }`);
    if (cue.transition !== "cut") lines.push(`transition = "${cue.transition}"`, `seconds = ${cue.seconds}`);
    if (cue.curve !== "hold") lines.push(`curve = "${cue.curve}"`);
  }
  return `${lines.join("\n")}\n`;
}

/** Returns what is wrong with the cues, or "". @param {Sheet} sheet @param {Cue[]} cues */
export function mistake(sheet, cues) {
  const used = cues.filter((cue) => !isEmpty(cue));
  if (!used.length) return "Choose a style first.";
  if (!used[0]?.style) return "The first cue needs a style.";
  for (const [number, cue] of used.slice(0, -1).entries()) {
    const now = timeOf(sheet, cue), rest = timeOf(sheet, /** @type {Cue} */ (used[number + 1])) - now;
    if (rest <= 0) return `Two cues begin at ${now} s.`;
    if (cue.seconds > rest) return `The ${cue.transition} at ${now} s takes ${cue.seconds} s, but the next cue begins after ${rest.toFixed(2)} s.`;
  }
  return "";
}
