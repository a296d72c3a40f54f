// The layout of the cards and wires of a diagram. The base runs in rows from left to right; background and lines
// follow as two lanes, one below the other, which join at the result. Wires of saved pictures run between the rows.

import { LAYERS } from "./types.js";

/** @typedef {import("./types.js").Layer} Layer */
/** @typedef {"source" | "result" | number | string} CardName the number of a step, the name of a fold, or that of an empty layer */
/** @typedef {{name: CardName, x: number, y: number, row: number}} Card */
/** @typedef {{layer: Layer, index: number, x: number, y: number}} Gap a position at which a step can be added */
/** @typedef {{points: [number, number][], saved: string, used: boolean, from?: CardName, to?: CardName}} Wire */
/** @typedef {import("./fold.js").Folded["edges"][number]} Edge */
/** @typedef {{w: number, h: number, gap: number, row: number, name: string}} Size dimensions of cards and of the space between them */

/**
 * @typedef {object} Layout
 * @property {Size} size
 * @property {Card[]} cards
 * @property {Card[]} stops the stops of arrow keys: cards, and the gaps of empty layers
 * @property {Gap[]} gaps
 * @property {Wire[]} wires
 * @property {{layer: Layer, x: number, y: number}[]} labels
 * @property {number} width
 * @property {number} height
 * @property {number} rows
 */

/** Sizes of cards from large to small; a card has a picture and two lines of text below it, of its name only if it is tiny. @type {Size[]} */
const CARD_SIZES = [168, 156, 144, 132, 122, 112, 104, 92, 80, 72].map((w) => {
  const [name, text, flat] = w > 125 ? ["large", 42, 9 / 16] : w > 104 ? ["medium", 40, 9 / 16] : w > 92 ? ["small", 33, 0.43] : ["tiny", 28, 0.4];
  return { name, w, h: Math.round(w * flat) + text, gap: 24 + (w - 104) / 6, row: Math.max(11, 15 + (w - 104) / 4) };
});
/** Space on the left and right of the diagram. All lengths are CSS pixels. */
const MARGIN_PX = 36;
/** Where the first and the last wire run that pass rows on the left. */
const MARGIN_WIRES_PX = [12, 4];
/** Distance between parallel wires of saved pictures. */
const TRACK_PX = 7;
/** Space for the name of a layer before its first card. */
const LABEL_PX = { base: 78, lanes: 108 };
/** Space before the result, where both lanes join. */
const JOIN_PX = 44;

/**
 * Returns the layout with the fewest rows and the largest cards that then fit; with more rows, or tiny cards, only where
 * nothing else fits.
 * @param {import("./fold.js").Folded} state
 * @param {number} width
 * @param {number} height
 * @returns {Layout}
 */
export function layoutOf(state, width, height) {
  const tried = CARD_SIZES.map((size) => new Arrangement(state, width, size).layout);
  const fitting = tried.filter((layout) => layout.height <= height && layout.width <= width);
  const readable = tried.filter(({ size }) => size.name !== "tiny");
  const fewest = Math.min(...readable.map(({ rows }) => rows));
  return fitting.find(({ rows, size }) => rows === fewest && size.name !== "tiny") ?? fitting[0] ?? tried[tried.length - 1];
}

/** Cards in rows, and the wires between them. */
class Arrangement {
  /**
   * @param {import("./fold.js").Folded} state
   * @param {number} width
   * @param {Size} size
   */
  constructor(state, width, size) {
    this.state = state;
    this.size = size;
    this.pitch = size.w + size.gap;
    this.right = width - MARGIN_PX;
    /** @type {Map<CardName, Card>} */
    this.cards = new Map();
    /** @type {Gap[]} */
    this.gaps = [];
    /** @type {Layout["labels"]} */
    this.labels = [];
    const trunkEnd = this.trunk();
    const lanes = this.lanes(trunkEnd);
    /** Occupied parts of the tracks in the gutter below each row. @type {{key: string, from: number, to: number}[][][]} */
    this.gutters = Array.from({ length: lanes.rows }, () => []);
    /** @type {string[]} */
    this.margin = [];
    const routes = state.edges.map((edge) => this.route(edge)).filter((route) => route !== null);
    this.place();
    const wires = [...this.chain(lanes), ...routes.map((route) => this.saved(route))];
    const width_ = Math.max(...[...this.cards.values()].map((card) => card.x + size.w)) + MARGIN_PX;
    const height = this.tops[lanes.rows - 1] + size.h + this.depth(lanes.rows - 1) + 8;
    /** @type {Layout} */
    this.layout = { size, cards: [...this.cards.values()], stops: this.stops(lanes), gaps: this.gaps, wires, labels: this.labels, width: width_, height, rows: lanes.rows };
  }

  /** @param {CardName} name @param {number} x @param {number} row */
  add(name, x, row) {
    const card = { name, x, y: 0, row };
    this.cards.set(name, card);
    return card;
  }

  /** Places the source and the base; returns their last card. */
  trunk() {
    let last = this.add("source", MARGIN_PX, 0);
    this.state.items.base.forEach(({ step }, index) => {
      let x = last.x + this.pitch + (index ? 0 : LABEL_PX.base - this.size.gap);
      const wraps = x + this.size.w > this.right;
      if (wraps) x = MARGIN_PX;
      last = this.add(step, x, last.row + Number(wraps));
    });
    return last;
  }

  /**
   * Places both lanes and the result, behind or below the base, whichever takes fewer rows.
   * @param {Card} end the last card of the base
   */
  lanes(end) {
    const counts = [this.state.items.background.length, this.state.items.lines.length];
    const empty = this.state.items.base.length ? 0 : LABEL_PX.base - 20;
    const behind = { x: end.x + this.size.w + LABEL_PX.lanes + empty, row: end.row };
    const below = { x: MARGIN_PX + LABEL_PX.lanes - 46, row: end.row + 1 };
    const plans = [behind, below].map(({ x, row }) => {
      const room = Math.floor((this.right - this.size.w - JOIN_PX - x + this.size.gap) / this.pitch);
      const rows = counts.map((count) => Math.max(1, Math.ceil(count / Math.max(room, 1))));
      return { x, row, room, rows, total: row + rows[0] + rows[1] };
    });
    const fits = plans.filter((plan) => plan.room >= 1);
    const plan = fits.reduce((best, each) => (each.total < best.total ? each : best), fits[0] ?? plans[1]);
    const room = Math.max(plan.room, 1);
    const starts = [plan.row, plan.row + plan.rows[0]];
    /** @type {Layer[]} */ (["background", "lines"]).forEach((layer, lane) => {
      this.state.items[layer].forEach(({ step }, index) => {
        this.add(step, plan.x + (index % room) * this.pitch, starts[lane] + Math.floor(index / room));
      });
    });
    const longest = Math.min(room, Math.max(...counts, 1));
    const edge = plan.x + longest * this.pitch - this.size.gap;
    const shortened = counts[0] + counts[1] === 0 ? this.size.w : 0;
    this.add("result", edge + JOIN_PX - shortened, plan.row);
    return { end, x: plan.x, starts, join: edge + JOIN_PX / 2 + 6 - shortened, rows: plan.total, room };
  }

  /**
   * Reserves tracks for a saved picture: below both cards if their rows are adjacent, else along the margin.
   * @param {Edge} edge
   */
  route(edge) {
    const [from, to] = [this.cards.get(edge.from), this.cards.get(edge.to)];
    if (!from || !to) return null;
    const key = `${edge.name} ${edge.from}`;
    const [exit, entry] = [from.x + 0.72 * this.size.w, to.x + this.entry(edge) * this.size.w];
    const below = to.row === from.row ? to.row : to.row - 1;
    if (below <= from.row) {
      const track = this.track(from.row, key, exit, entry);
      return { edge, from, to, exit, entry, tracks: [track], margin: -1 };
    }
    if (!this.margin.includes(key)) this.margin.push(key);
    const margin = this.margin.indexOf(key);
    const tracks = [this.track(from.row, key, 0, exit), this.track(below, key, 0, entry)];
    return { edge, from, to, exit, entry, tracks, margin };
  }

  /** Returns where a wire enters a card, as a fraction of its width; wires into one card enter side by side. @param {Edge} edge */
  entry(edge) {
    const all = this.state.edges.filter((each) => each.to === edge.to);
    return 0.2 + 0.3 * (all.indexOf(edge) / Math.max(all.length, 1));
  }

  /** @param {number} row @param {string} key @param {number} one @param {number} other */
  track(row, key, one, other) {
    const piece = { key, from: Math.min(one, other) - 6, to: Math.max(one, other) + 6 };
    const gutter = this.gutters[row];
    let track = gutter.findIndex((pieces) => pieces.every((each) => each.key === key || each.to < piece.from || each.from > piece.to));
    if (track < 0) track = gutter.push([]) - 1;
    gutter[track].push(piece);
    return track;
  }

  /** Returns the height of the gutter below a row. @param {number} row */
  depth(row) {
    return this.size.row + TRACK_PX * (this.gutters[row]?.length ?? 0);
  }

  /** Sets the top of each row and moves the cards there. */
  place() {
    /** @type {number[]} */
    this.tops = [14];
    for (let row = 1; row <= this.gutters.length; row++) this.tops.push(this.tops[row - 1] + this.size.h + this.depth(row - 1));
    for (const card of this.cards.values()) card.y = this.tops[card.row];
  }

  /** Returns the y coordinate at which the wires between the cards of a row run. @param {number} row */
  middle(row) {
    return this.tops[row] + 0.32 * this.size.h;
  }

  /**
   * Returns the wires between steps, and records the gaps at which steps can be added.
   * @param {ReturnType<Arrangement["lanes"]>} lanes
   * @returns {Wire[]}
   */
  chain(lanes) {
    /** @type {Wire[]} */
    const wires = [];
    const { items: layers, lengths } = this.state;
    const source = /** @type {Card} */ (this.cards.get("source"));
    const isBelow = lanes.starts[0] > lanes.end.row;
    // Where the wire turns down at once, the name of the empty layer is behind its button.
    this.labels.push({ layer: "base", x: source.x + this.size.w + (isBelow && !layers.base.length ? 30 : 10), y: this.middle(0) });
    this.row("base", source, wires);
    const from = lanes.end.x + this.size.w;
    const empty = layers.base.length ? 0 : LABEL_PX.base - 20;
    const fork = isBelow ? MARGIN_PX - 16 : from + 30 + empty;
    const y = this.middle(lanes.end.row);
    this.gaps.push({ layer: "base", index: lengths.base, x: from + 14 + (empty && !isBelow ? 46 : 0), y });
    const result = /** @type {Card} */ (this.cards.get("result"));
    /** @type {Layer[]} */ (["background", "lines"]).forEach((layer, lane) => {
      const start = this.middle(lanes.starts[lane]);
      const [first] = layers[layer];
      const used = layers[layer].length > 0 || (layer === "background" && !layers.lines.length);
      const gutter = this.tops[lanes.end.row] + this.size.h + this.depth(lanes.end.row) - this.size.row / 2;
      /** @type {[number, number][]} */
      const way = isBelow ? [[from, y], [from + 14, y], [from + 14, gutter], [fork, gutter], [fork, start]] : [[from, y], [fork, y], [fork, start]];
      this.labels.push({ layer, x: fork + 8, y: start });
      this.gaps.push({ layer, index: 0, x: lanes.x - 16, y: start });
      const last = layers[layer].at(-1);
      const end = last ? this.cards.get(last.step) : null;
      const [outX, outY] = end ? [end.x + this.size.w, this.middle(end.row)] : [lanes.x - 16, start];
      wires.push({ points: [...way, [first ? lanes.x : outX, start]], saved: "", used: used && !first?.from });
      if (first) this.row(layer, { name: "source", x: lanes.x - this.pitch, y: 0, row: lanes.starts[lane] }, wires);
      if (end) this.gaps.push({ layer, index: lengths[layer], x: outX + 14, y: outY });
      const into = this.middle(result.row);
      wires.push({ points: [[outX, outY], [lanes.join, outY], [lanes.join, into], [result.x, into]], saved: "", used });
    });
    return wires;
  }

  /** @param {ReturnType<Arrangement["lanes"]>} lanes */
  stops(lanes) {
    const cards = [...this.cards.values()];
    const [result] = cards.splice(-1);
    const first = this.state.items.base.length + 1;
    const background = first + this.state.items.background.length;
    /** @type {(layer: Layer, lane: number) => Card[]} */
    const empty = (layer, lane) => {
      const row = lanes.starts[lane];
      return this.state.items[layer].length ? [] : [{ name: layer, x: lanes.x - 16, y: this.middle(row), row }];
    };
    return [...cards.slice(0, first), ...empty("background", 0), ...cards.slice(first, background), ...empty("lines", 1), ...cards.slice(background), result];
  }

  /**
   * Adds the wires between the cards of a layer, and the gaps before its cards except the first of a lane.
   * @param {Layer} layer @param {Card} before @param {Wire[]} wires
   */
  row(layer, before, wires) {
    let last = before;
    for (const step of this.state.items[layer]) {
      const { index } = step;
      const card = /** @type {Card} */ (this.cards.get(step.step));
      const starts = last === before && layer !== LAYERS[0];
      const [from, to] = [this.middle(last.row), this.middle(card.row)];
      const out = last.x + this.size.w;
      if (!starts && last.row === card.row) {
        wires.push({ points: [[out, from], [card.x, to]], saved: "", used: !step.from });
        this.gaps.push({ layer, index, x: card.x - this.size.gap / 2, y: to });
      } else if (!starts) {
        const gutter = card.y - this.size.row / 2;
        const [turn, back] = [out + 12, card.x - 16];
        wires.push({ points: [[out, from], [turn, from], [turn, gutter], [back, gutter], [back, to], [card.x, to]], saved: "", used: !step.from });
        this.gaps.push({ layer, index, x: turn, y: from });
      }
      last = card;
    }
  }

  /**
   * Returns the wire of a saved picture.
   * @param {NonNullable<ReturnType<Arrangement["route"]>>} route
   * @returns {Wire}
   */
  saved({ edge, from, to, exit, entry, tracks, margin }) {
    const out = this.tops[from.row] + this.size.h;
    /** @param {number} row @param {number} track */
    const at = (row, track) => this.tops[row] + this.size.h + 7 + TRACK_PX * track;
    const first = at(from.row, tracks[0]);
    const into = to.row === from.row ? to.y + this.size.h : to.y;
    /** @type {[number, number][]} */
    let points = [[exit, out], [exit, first], [entry, first], [entry, into]];
    if (margin >= 0) {
      const second = at(to.row - 1, tracks[1]);
      const x = MARGIN_WIRES_PX[0] - margin * Math.min(4, (MARGIN_WIRES_PX[0] - MARGIN_WIRES_PX[1]) / Math.max(1, this.margin.length - 1));
      points = [[exit, out], [exit, first], [x, first], [x, second], [entry, second], [entry, into]];
    }
    return { points, saved: edge.name, used: true, from: edge.from, to: edge.to };
  }
}

/**
 * Returns the SVG path of a wire, with rounded corners.
 * @param {[number, number][]} points
 * @param {number} radius
 */
export function pathOf(points, radius) {
  const parts = [`M${points[0]}`];
  for (let at = 1; at < points.length - 1; at++) {
    const [before, here, after] = [points[at - 1], points[at], points[at + 1]];
    const [enter, leave] = [before, after].map((other) => {
      const length = Math.hypot(other[0] - here[0], other[1] - here[1]);
      const part = length ? Math.min(radius, length / 2) / length : 0;
      return [here[0] + part * (other[0] - here[0]), here[1] + part * (other[1] - here[1])];
    });
    parts.push(`L${enter} Q${here} ${leave}`);
  }
  return `${parts.join(" ")} L${points[points.length - 1]}`;
}
