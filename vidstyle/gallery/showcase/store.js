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

/** @typedef {import("./viewer.js").StyleData & {file: StyleFile}} ShowcaseStyle */
/** @type {Map<string, Promise<ShowcaseStyle>>} */
const styles = new Map();

/** Returns the data of a style, with its shader texts and textures. @param {string} name @returns {Promise<ShowcaseStyle>} */
export function loadStyleData(name) {
  const found = styles.get(name) ?? readStyle(name);
  styles.set(name, found);
  found.catch(() => styles.delete(name));
  return found;
}

/** @param {string} name @returns {Promise<ShowcaseStyle>} */
async function readStyle(name) {
  const [pieces, data] = await Promise.all([load("shaders"), load(`styles/${name}`)]);
  const textures = await Promise.all(data.textures.map(async (/** @type {string} */ texture) => [texture, await load(`textures/${texture}`)]));
  const texts = data.shaders.map((/** @type {number[]} */ numbers) => numbers.map((number) => pieces[number]).join("\n"));
  const plans = data.plans.map((/** @type {import("./plan_values.js").SizedPlan} */ sized) => ({
    ...sized,
    plan: {
      ...sized.plan,
      vertex: pieces[data.vertex],
      shaders: sized.plan.shaders.map((number) => texts[Number(number)]),
      textures: Object.fromEntries(textures),
    },
  }));
  return { ...data, plans };
}

/** @typedef {{text: string, places: Record<string, [number, boolean]>}} StyleFile the line that sets the value of a control, by path; or the line before it, and false */
