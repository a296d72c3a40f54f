/**
 * The WebSocket of a page: questions with answers, pictures, and a new connection once one is lost.
 *
 * @module
 */

/**
 * A picture from the server: a header of 16 bytes, then a PNG or JPEG file.
 * @typedef {object} Packet
 * @property {number} type what it shows
 * @property {number} number of a frame, a step or a place in a list
 * @property {number} revision of the document that it shows
 * @property {Blob} file
 */

const HEADER = 16;
const AGAIN_MS = 1000;
/** Bytes of one message of a file; the server takes 65,536. */
const CHUNK = 60000;
/** Bytes that may wait to be sent. */
const WAITING = 4 << 20;

/** A connection that lasts as long as the page. */
export class Connection {
  /** @type {WebSocket | null} */
  #socket = null;
  #number = 0;
  /** @type {Map<number, {done: (answer: any) => void, fail: (error: Error) => void}>} */
  #waiting = new Map();
  /** What waits for the answer to an earlier message of its kind. @type {Map<string, [string, object] | null>} */
  #newest = new Map();

  /**
   * @param {object} handlers
   * @param {(message: any) => void} handlers.onmessage gets every message that answers no question
   * @param {(packet: Packet) => void} handlers.onpicture
   * @param {(open: boolean) => void} handlers.onchange is told when the connection is there or lost
   */
  constructor(handlers) {
    this.handlers = handlers;
    this.#open();
  }

  #open() {
    const socket = new WebSocket(`ws://${location.host}/socket`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.#socket = socket;
      this.handlers.onchange(true);
    };
    socket.onmessage = ({ data }) => (typeof data === "string" ? this.#take(JSON.parse(data)) : this.#takePicture(data));
    socket.onclose = () => {
      this.#socket = null;
      for (const { fail } of this.#waiting.values()) fail(new Error("The connection to vidstyle is lost."));
      this.#waiting.clear();
      this.#newest.clear();
      this.handlers.onchange(false);
      setTimeout(() => this.#open(), AGAIN_MS);
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
    const header = new DataView(data, 0, HEADER);
    const file = new Blob([new Uint8Array(data, HEADER)]);
    const revision = Number(header.getBigUint64(8));
    this.handlers.onpicture({ type: header.getUint8(0), number: header.getUint32(4), revision, file });
  }

  /**
   * Sends a message; the answer, or the server's sentence as an error.
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

  /** The next answer to a message. @param {number} id @returns {Promise<any>} */
  #answer(id) {
    if (!this.#socket) return Promise.reject(new Error("There is no connection to vidstyle."));
    return new Promise((done, fail) => this.#waiting.set(id, { done, fail }));
  }

  /**
   * Sends a message once the earlier ones with this key are answered; only the newest is kept meanwhile.
   * @param {string} key
   * @param {string} kind
   * @param {object} fields
   * @param {(error: Error) => void} onerror
   */
  async newest(key, kind, fields, onerror) {
    if (this.#newest.has(key)) {
      this.#newest.set(key, [kind, fields]);
      return;
    }
    this.#newest.set(key, null);
    try {
      await this.ask(kind, fields);
    } catch (error) {
      onerror(/** @type {Error} */ (error));
    }
    const next = this.#newest.get(key);
    this.#newest.delete(key);
    if (next) await this.newest(key, ...next, onerror);
  }

  /**
   * Sends a file in parts: it is announced, and answered once more when it has been used.
   * @param {File} file
   * @param {(part: number) => void} onprogress is told the part that is sent
   */
  async upload(file, onprogress) {
    const announced = this.ask("upload", { name: file.name, size: file.size });
    const id = this.#number;
    await announced;
    const used = this.#answer(id);
    for (let at = 0; at < file.size && this.#socket; at += CHUNK) {
      this.#socket.send(await file.slice(at, at + CHUNK).arrayBuffer());
      while (Number(this.#socket?.bufferedAmount) > WAITING) await new Promise((done) => setTimeout(done, 20));
      onprogress(Math.min(1, (at + CHUNK) / file.size));
    }
    return used;
  }
}
