// The client side of the document: the newest state, and requests to edit it.

import { Connection } from "./socket.js";

/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").Entry} Entry */

/** Changes of one value that are this far apart are separate undo steps. */
const UNDO_PAUSE_MS = 900;
/** Messages that do not concern the document. */
const VIEW_MESSAGES = new Set(["watch", "frame", "play", "pause", "find", "scenes", "cues"]);

/** Groups edits for undo: changes of one value while the pointer is down, or in quick succession. */
class Gestures {
  #number = 0;
  #key = "";
  #last = 0;
  #held = false;

  constructor() {
    addEventListener("pointerdown", () => this.#hold(true), true);
    for (const kind of ["pointerup", "pointercancel"]) addEventListener(kind, () => this.#hold(false), true);
    addEventListener("blur", () => this.#hold(false));
  }

  /** @param {boolean} held */
  #hold(held) {
    this.#held = held;
    if (held) this.#key = "";
  }

  /** Returns the number of the gesture that an edit belongs to. @param {string} key the changed value; "" for a separate undo step */
  of(key) {
    const now = performance.now();
    if (!key || key !== this.#key || (!this.#held && now - this.#last > UNDO_PAUSE_MS)) this.#number += 1;
    this.#key = key;
    this.#last = now;
    return this.#number;
  }
}

/**
 * Applies changes to a copy of a state.
 * @template T
 * @param {T} before
 * @param {[(string | number)[], any][]} changes from `vidstyle.web.changes`: path and new value
 * @returns {T} a changed copy
 */
function applyChanges(before, changes) {
  const after = { root: structuredClone(before) };
  for (const [path, value] of changes) {
    const keys = ["root", ...path];
    const last = /** @type {string | number} */ (keys.pop());
    /** @type {any} */
    let place = after;
    for (const key of keys) place = place[key];
    place[last] = value;
  }
  return after.root;
}

/** The document as the server last sent it. */
export class Session {
  /** @type {State | null} */
  state = null;
  /** @type {import("./types.js").Block[]} */
  blocks = [];
  /** @type {import("./types.js").StyleInfo[]} */
  styles = [];
  /** @type {import("./player.js").Clip | null} */
  clip = null;
  #gestures = new Gestures();
  /** @type {Map<string, ((value: any) => void)[]>} */
  #listeners = new Map();
  /** Values that were not answered before the connection was lost. @type {Map<string, [string, object]>} */
  #lost = new Map();
  /** Values that are being sent. @type {Map<string, Promise<void>>} */
  #busy = new Map();

  /** @param {(text: string) => void} onerror is called with the message of an error */
  constructor(onerror) {
    this.onerror = onerror;
    this.connection = new Connection({
      onmessage: (message) => this.#take(message),
      onpicture: (packet) => this.#tell("picture", packet),
      onchange: (loss) => this.#changed(loss),
    });
  }

  /**
   * Calls a function for each message of a kind: "state", "plan", "blocks", "styles", "clip", "draft", "progress",
   * "making", "notice"; "picture" and "connection".
   * @param {string} kind
   * @param {(value: any) => void} listener
   */
  on(kind, listener) {
    this.#listeners.set(kind, [...(this.#listeners.get(kind) ?? []), listener]);
  }

  /** Returns the address of the picture of a block on the clip, or of the clip: "source". @param {string} name */
  sampleAt(name) {
    return `block.jpg?${new URLSearchParams({ of: name, on: this.clip?.name ?? "" })}`;
  }

  /** Sends the values again that were lost with the connection. @param {import("./socket.js").Loss | null} loss */
  #changed(loss) {
    this.#tell("connection", loss);
    if (loss) return;
    const lost = [...this.#lost];
    this.#lost.clear();
    for (const [key, [kind, fields]] of lost) this.#newest(key, kind, fields);
  }

  /** @param {string} kind @param {any} value */
  #tell(kind, value) {
    for (const listener of this.#listeners.get(kind) ?? []) listener(value);
  }

  /** @param {Object<string, any>} message */
  #take(message) {
    for (const [kind, value] of Object.entries(message)) {
      if (kind === "changes") {
        this.state = applyChanges(this.state, value);
        this.#tell("state", this.state);
        continue;
      }
      if (kind === "state") this.state = value;
      if (kind === "blocks") this.blocks = value;
      if (kind === "styles") this.styles = value;
      if (kind === "clip") this.clip = value;
      this.#tell(kind, value);
    }
  }

  /**
   * Sends a request and resolves to its answer; reports an error to the user. Requests that concern the document
   * wait until all pending values have been sent.
   * @param {string} kind
   * @param {object} [fields]
   * @returns {Promise<any>} null after an error
   */
  async ask(kind, fields = {}) {
    try {
      return await this.attempt(kind, fields);
    } catch (error) {
      if (this.connection.isOpen) this.onerror(/** @type {Error} */ (error).message); // else the notice says it
      return null;
    }
  }

  /**
   * Like `ask`, but rejects with the error.
   * @param {string} kind
   * @param {object} fields
   * @returns {Promise<any>}
   */
  async attempt(kind, fields) {
    if (!VIEW_MESSAGES.has(kind)) await Promise.all(this.#busy.values());
    return this.connection.ask(kind, fields);
  }

  /**
   * Edits the document as one undo step.
   * @param {string} kind
   * @param {object} fields
   */
  edit(kind, fields) {
    return this.ask(kind, { ...fields, gesture: this.#gestures.of("") });
  }

  /**
   * Changes a value; quick changes of one value are one undo step.
   * @param {Entry} entry
   * @param {any} value
   */
  set({ step, name, path }, value) {
    const gesture = this.#gestures.of(path);
    if (step === null) this.#newest(path, "field", { name, value, gesture });
    else this.#newest(path, "set", { step, name, value, gesture });
  }

  /** @param {string} key @param {string} kind @param {object} fields */
  #newest(key, kind, fields) {
    const sent = this.connection.newest(key, kind, fields, (error) => {
      if (this.connection.isOpen) this.onerror(error.message);
      else this.#lost.set(key, [kind, fields]);
    });
    const settled = sent.then(() => {
      if (this.#busy.get(key) !== settled) return; // a newer value is being sent
      this.#busy.delete(key);
      this.#tell("settled", key);
    });
    this.#busy.set(key, settled);
  }

  /** Whether a change of this value is being sent. @param {string} path */
  isBusy(path) {
    return this.#busy.has(path);
  }
}
