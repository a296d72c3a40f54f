// A style and its values in the address of a page, so that a link shows the same picture to others.

/** @typedef {import("./plan_values.js").Entry} Entry */

/** Returns the address of a style with changed values. @param {string} name @param {Record<string, any>} changes by path */
export function addressOf(name, changes) {
  const values = Object.entries(changes).map((pair) => pair.map(encodeURIComponent).join("="));
  return `${location.href.split("#")[0]}#${[encodeURIComponent(name), ...values].join("&")}`;
}

/** Returns the name of the style in the address of this page; "" if there is none. */
export function addressedStyle() {
  const [name] = location.hash.slice(1).split("&");
  try {
    return decodeURIComponent(name);
  } catch {
    return "";
  }
}

/**
 * Returns the values in the address of this page that the controls allow. Links come from strangers.
 * @param {Entry[]} entries
 * @returns {Record<string, any>} by path
 */
export function addressedValues(entries) {
  const found = new URLSearchParams(location.hash.replace(/^#[^&]*&?/, ""));
  /** @type {Record<string, any>} */
  const values = {};
  for (const entry of entries) {
    const value = found.has(entry.path) ? parse(entry, found.get(entry.path) ?? "") : null;
    if (value !== null) values[entry.path] = value;
  }
  return values;
}

/** Returns the value that a text gives for a control, or null. @param {Entry} entry @param {string} text */
function parse({ kind, low = -Infinity, high = Infinity, whole, options }, text) {
  const number = Number(text);
  if (kind === "slider") return text && number >= low && number <= high && (!whole || Number.isInteger(number)) ? number : null;
  if (kind === "switch") return text === "true" ? true : text === "false" ? false : null;
  if (kind === "color") return /^#[0-9a-f]{6}$/i.test(text) ? text : null;
  return options?.includes(text) ? text : null;
}
