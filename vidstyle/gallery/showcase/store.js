// Data in separate files, each loaded once. They are scripts, since browsers do not let a local page read files.

/** @type {Map<string, {value: Promise<any>, settle: (value: any) => void, fail: (error: Error) => void}>} */
const pending = new Map();

/** Receives the value of a file; the files call it. @param {string} path @param {any} value */
function receive(path, value) {
  pending.get(path)?.settle(value);
}
Object.assign(globalThis, { vidstyleData: receive });

/** Returns the value of a file of the folder `data`. @param {string} path without extension @returns {Promise<any>} */
export function load(path) {
  const known = pending.get(path);
  if (known) return known.value;
  /** @type {PromiseWithResolvers<any>} */
  const { promise, resolve, reject } = Promise.withResolvers();
  pending.set(path, { value: promise, settle: resolve, fail: reject });
  const script = document.createElement("script");
  script.src = `data/${path.split("/").map(encodeURIComponent).join("/")}.js`;
  script.addEventListener("error", () => {
    pending.delete(path);
    reject(new Error(`data/${path}.js is missing or cannot be read`));
  });
  document.head.append(script);
  return promise;
}

/**
 * Returns the data of a style, with its shader texts and textures.
 * @param {string} name
 * @returns {Promise<import("./viewer.js").StyleData & {file: StyleFile}>}
 */
export async function loadStyleData(name) {
  const [pieces, data] = await Promise.all([load("shaders"), load(`styles/${name}`)]);
  if (!data.isComplete) {
    const textures = await Promise.all(data.textures.map(async (/** @type {string} */ texture) => [texture, await load(`textures/${texture}`)]));
    const texts = data.shaders.map((/** @type {number[]} */ numbers) => numbers.map((number) => pieces[number]).join("\n"));
    for (const { plan } of data.plans) {
      plan.vertex = pieces[data.vertex];
      plan.shaders = plan.shaders.map((/** @type {number} */ number) => texts[number]);
      plan.textures = Object.fromEntries(textures);
    }
    data.isComplete = true;
  }
  return data;
}

/** @typedef {{text: string, places: Record<string, [number, boolean]>}} StyleFile the line that sets the value of a control, by path; or the line before it, and false */
