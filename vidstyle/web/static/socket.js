// The WebSocket of a page: requests with answers, pictures, uploads, and reconnection.

/**
 * A picture from the server: a header of 16 bytes, then a PNG or JPEG file.
 * @typedef {object} Packet
 * @property {number} type the type of the picture
 * @property {number} number the number of a frame, a step or an item of a list
 * @property {number} revision the revision of the document that it shows
 * @property {Blob} file
 */

const HEADER_BYTES = 16;
const RECONNECT_MS = 1000;
const GOING_AWAY_CODE = 1001;
const FORBIDDEN = 403;

/**
 * Why the connection is lost: "broken" for an unknown reason, "full" as too many browsers are connected,
 * "stopped" as the server does not run, "restarted" as another server runs at its address.
 * @typedef {"broken" | "full" | "restarted" | "stopped"} Loss
 */

/** Finds out why the server does not answer. @returns {Promise<Loss>} */
async function findLoss() {
  try {
    const { status } = await fetch("icon.svg", { cache: "no-store" });
    return status === FORBIDDEN ? "restarted" : "full";
  } catch {
    return "stopped";
  }
}
/** Size of the messages of an upload; the server accepts at most 65,536 bytes. */
const CHUNK_BYTES = 60000;
/** Size of the send buffer at which an upload pauses. */
const MAX_BUFFERED_BYTES = 4 << 20;

/** A connection that is restored until the page closes. */
export class Connection {
  /** @type {WebSocket | null} */
  #socket = null;
  #number = 0;
  /** @type {Map<number, {done: (answer: any) => void, fail: (error: Error) => void}>} */
  #waiting = new Map();
  /** The newest unsent message for each key. @type {Map<string, [string, object]>} */
  #unsent = new Map();
  /** Resolves when all of them are answered. */
  #sending = Promise.resolve();

  /**
   * @param {object} handlers
   * @param {(message: any) => void} handlers.onmessage is called with each message that is not an answer
   * @param {(packet: Packet) => void} handlers.onpicture
   * @param {(loss: Loss | null) => void} handlers.onchange is called when the connection is opened, with null, or lost
   * @param {() => void} [handlers.onend] is called when the server has ended; without it, the page reconnects
   */
  constructor(handlers) {
    this.handlers = handlers;
    this.#open();
  }

  get isOpen() {
    return this.#socket !== null;
  }

  #open() {
    const socket = new WebSocket(`ws://${location.host}/socket`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.#socket = socket;
      this.handlers.onchange(null);
    };
    socket.onmessage = ({ data }) => (typeof data === "string" ? this.#take(JSON.parse(data)) : this.#takePicture(data));
    socket.onclose = async ({ code }) => {
      const wasOpen = this.#socket !== null;
      this.#socket = null;
      for (const { fail } of this.#waiting.values()) fail(new Error("Connection to vidstyle lost."));
      this.#waiting.clear();
      this.#unsent.clear();
      if (code === GOING_AWAY_CODE && this.handlers.onend) return this.handlers.onend();
      if (wasOpen) this.handlers.onchange(code === GOING_AWAY_CODE ? "stopped" : "broken");
      else this.handlers.onchange(await findLoss());
      setTimeout(() => this.#open(), RECONNECT_MS);
    };
  }

  /** @param {any} message */
  #take(message) {
    if (message.answer === undefined) return this.handlers.onmessage(message);
    const waiting = this.#waiting.get(message.answer);
    this.#waiting.delete(message.answer);
    if (message.error) waiting?.fail(new Error(message.error));
    else waiting?.done(message);
  }

  /** @param {ArrayBuffer} data */
  #takePicture(data) {
    const header = new DataView(data, 0, HEADER_BYTES);
    const file = new Blob([new Uint8Array(data, HEADER_BYTES)]);
    const revision = Number(header.getBigUint64(8));
    this.handlers.onpicture({ type: header.getUint8(0), number: header.getUint32(4), revision, file });
  }

  /**
   * Sends a request; resolves to its answer, or rejects with the error message of the server.
   * @param {string} kind
   * @param {object} [fields]
   * @returns {Promise<any>}
   */
  ask(kind, fields = {}) {
    const id = ++this.#number;
    const answer = this.#answer(id);
    this.#socket?.send(JSON.stringify({ do: kind, id, ...fields }));
    return answer;
  }

  /** Resolves to the next answer to a request. @param {number} id @returns {Promise<any>} */
  #answer(id) {
    if (!this.#socket) return Promise.reject(new Error("Not connected to vidstyle."));
    return new Promise((done, fail) => this.#waiting.set(id, { done, fail }));
  }

  /**
   * Sends a request once all earlier ones of this method are answered, so that they arrive in order. Until then,
   * a newer request with the same key replaces it.
   * @param {string} key
   * @param {string} kind
   * @param {object} fields
   * @param {(error: Error) => void} onerror
   * @returns {Promise<void>} resolves when the request and all before it are answered
   */
  newest(key, kind, fields, onerror) {
    const isQueued = this.#unsent.has(key);
    this.#unsent.set(key, [kind, fields]);
    if (!isQueued) this.#sending = this.#sending.then(() => this.#sendNewest(key, onerror));
    return this.#sending;
  }

  /** @param {string} key @param {(error: Error) => void} onerror */
  async #sendNewest(key, onerror) {
    const message = this.#unsent.get(key);
    this.#unsent.delete(key);
    try {
      if (message) await this.ask(...message);
    } catch (error) {
      onerror(/** @type {Error} */ (error));
    }
  }

  /**
   * Uploads a file in chunks; resolves once the server has used it.
   * @param {File} file
   * @param {(part: number) => void} onprogress is called with the fraction sent
   */
  async upload(file, onprogress) {
    const announced = this.ask("upload", { name: file.name, size: file.size });
    const id = this.#number;
    await announced;
    const used = this.#answer(id);
    for (let at = 0; at < file.size && this.#socket; at += CHUNK_BYTES) {
      this.#socket.send(await file.slice(at, at + CHUNK_BYTES).arrayBuffer());
      while (Number(this.#socket?.bufferedAmount) > MAX_BUFFERED_BYTES) await new Promise((done) => setTimeout(done, 20));
      onprogress(Math.min(1, (at + CHUNK_BYTES) / file.size));
    }
    return used;
  }
}
