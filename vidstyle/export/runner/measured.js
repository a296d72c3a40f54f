// Measurements of pictures, with smoothing over time.

/** @typedef {import("./runner.js").Film} Film */

/**
 * Returns percentiles with linear interpolation, as in `numpy.percentile`.
 * @param {Float32Array} numbers is sorted in place
 * @param {number[]} percentages
 * @returns {number[]}
 */
export function percentiles(numbers, percentages) {
  numbers.sort();
  return percentages.map((percentage) => {
    const rank = (percentage / 100) * (numbers.length - 1);
    const below = Math.floor(rank);
    const above = Math.min(below + 1, numbers.length - 1);
    return numbers[below] + (rank - below) * (numbers[above] - numbers[below]);
  });
}

/** First-order smoothing over time, as in `vidstyle.core.sampling.ExponentialSmoother`. */
export class Smoother {
  constructor() {
    /** @type {number[] | null} */
    this.numbers = null;
    /** @type {number | null} */
    this.time = null;
  }

  /**
   * Adds numbers and returns the smoothed result.
   * @param {number[]} numbers
   * @param {number | null} time in seconds; null for a still picture
   * @param {number} constant time constant in seconds; 0 disables smoothing
   * @returns {number[]}
   */
  follow(numbers, time, constant) {
    const before = this.time;
    this.time = time;
    const old = this.numbers;
    this.numbers = numbers;
    if (before !== null && time !== null && constant !== 0 && time >= before && old !== null) {
      const weight = 1 - Math.exp(-(time - before) / constant);
      this.numbers = numbers.map((number, each) => old[each] + weight * (number - old[each]));
    }
    return this.numbers;
  }
}

const RGB_TO_LMS_MATRIX = [[0.4122214708, 0.5363325363, 0.0514459929], [0.2119034982, 0.6806995451, 0.1073969566], [0.0883024619, 0.2817188376, 0.6299787005]];
const LMS_TO_LAB_MATRIX = [[0.210454255, 0.793617785, -0.004072047], [1.977998495, -2.428592205, 0.45059371], [0.025904037, 0.782771766, -0.808675766]];
const LAB_TO_LMS_MATRIX = [[1, 0.3963377774, 0.2158037573], [1, -0.1055613458, -0.0638541728], [1, -0.0894841775, -1.291485548]];
const LMS_TO_RGB_MATRIX = [[4.0767416621, -3.3077115913, 0.2309699292], [-1.2684380046, 2.6097574011, -0.3413193965], [-0.0041960863, -0.7034186147, 1.707614701]];

/** @param {number[][]} matrix @param {number[]} column */
const times = (matrix, column) => matrix.map((row) => row[0] * column[0] + row[1] * column[1] + row[2] * column[2]);

/** Converts sRGB 0..1 to OKLab. @param {number[]} rgb */
function labFromRgb(rgb) {
  const light = rgb.map((value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4));
  return times(LMS_TO_LAB_MATRIX, times(RGB_TO_LMS_MATRIX, light).map(Math.cbrt));
}

/** Converts OKLab to sRGB, clipped to 0..1. @param {number[]} lab */
function rgbFromLab(lab) {
  const light = times(LMS_TO_RGB_MATRIX, times(LAB_TO_LMS_MATRIX, lab).map((value) => value ** 3));
  return light.map((value) => Math.min(Math.max(value, 0), 1))
    .map((value) => (value <= 0.0031308 ? value * 12.92 : 1.055 * value ** (1 / 2.4) - 0.055));
}

/** @param {number[]} one @param {number[]} other */
const squaredDistance = (one, other) => (one[0] - other[0]) ** 2 + (one[1] - other[1]) ** 2 + (one[2] - other[2]) ** 2;

/** The main colours of a film, as in `vidstyle.core.film_colors.FilmColors`. */
export class FilmColors {
  /** @param {number} count of colours @param {Film} film */
  constructor(count, film) {
    this.count = count;
    this.film = film;
    this.smoother = new Smoother();
    /** @type {number[][] | null} */
    this.groups = null;
    /** @type {number[][] | null} */
    this.shown = null;
  }

  restart() {
    this.groups = this.shown = this.smoother.time = null;
  }

  /**
   * Adds a picture and returns the table of colours: rows of OKLab, then of red, green and blue.
   * @param {Uint8Array} texels of a reduced copy, four per pixel
   * @param {number | null} time in seconds; null for a still picture
   */
  follow(texels, time) {
    if (time === null) this.restart();
    const { chroma, held } = this.film;
    const bins = this.binned(texels);
    for (const bin of bins) bin.lab = [bin.lab[0], chroma * bin.lab[1], chroma * bin.lab[2]];
    const rounds = this.film.rounds[this.groups ? 1 : 0];
    let groups = this.groups ?? this.seeds(bins);
    for (let round = 0; round < rounds; round++) groups = regroup(bins, groups);
    this.groups = groups;
    const flat = this.smoother.follow(groups.flat(), time, this.film.settle);
    const wanted = groups.map((_, each) => [flat[3 * each], flat[3 * each + 1] / chroma, flat[3 * each + 2] / chroma]);
    this.shown = wanted.map((lab, each) => (this.shown && squaredDistance(lab, this.shown[each]) <= held ** 2 ? this.shown[each] : lab));
    const rgb = this.shown.map(rgbFromLab);
    const columns = rgb.map((color) => [...labFromRgb(color), ...color]);
    return Float32Array.from({ length: 6 * this.count }, (_, at) => columns[at % this.count][Math.floor(at / this.count)]);
  }

  /** @private @param {Uint8Array} texels @returns {{lab: number[], weight: number}[]} */
  binned(texels) {
    const { bins, skin: [red, yellow, radius, most] } = this.film;
    /** @type {Map<number, number[]>} */
    const found = new Map();
    for (let at = 0; at < texels.length; at += 4) {
      const lab = labFromRgb([texels[at] / 255, texels[at + 1] / 255, texels[at + 2] / 255]);
      const [lightness, a, b] = lab.map((value) => Math.floor(value * bins) + bins);
      const cube = (lightness * 3 * bins + a) * 3 * bins + b;
      const sums = found.get(cube) ?? [0, 0, 0, 0];
      found.set(cube, [sums[0] + lab[0], sums[1] + lab[1], sums[2] + lab[2], sums[3] + 1]);
    }
    const cubes = [...found.keys()].sort((one, other) => one - other);
    return cubes.map((cube) => {
      const [lightness, a, b, count] = /** @type {number[]} */ (found.get(cube));
      const away = ((a / count - red) ** 2 + (b / count - yellow) ** 2) / radius ** 2;
      return { lab: [lightness / count, a / count, b / count], weight: Math.sqrt(count) * (1 + (most - 1) * 0.5 ** away) };
    });
  }

  /** @private @param {{lab: number[], weight: number}[]} bins @returns {number[][]} */
  seeds(bins) {
    const away = bins.map(() => Infinity);
    const most = (/** @type {number[]} */ numbers) => bins[numbers.indexOf(Math.max(...numbers))].lab;
    const taken = [most(bins.map((bin) => bin.weight))];
    while (taken.length < this.count) {
      bins.forEach((bin, each) => { away[each] = Math.min(away[each], squaredDistance(bin.lab, taken[taken.length - 1])); });
      taken.push(most(bins.map((bin, each) => bin.weight * away[each])));
    }
    return taken;
  }
}

/** One round of k-means. @param {{lab: number[], weight: number}[]} bins @param {number[][]} groups */
function regroup(bins, groups) {
  const sums = groups.map(() => [0, 0, 0, 0]);
  const wrong = bins.map(({ lab, weight }) => {
    let nearest = 0;
    for (let each = 1; each < groups.length; each++) if (squaredDistance(lab, groups[each]) < squaredDistance(lab, groups[nearest])) nearest = each;
    [...lab, 1].forEach((part, at) => { sums[nearest][at] += weight * part; });
    return weight * squaredDistance(lab, groups[nearest]);
  });
  return sums.map(([lightness, a, b, total]) => {
    if (total > 0) return [lightness / total, a / total, b / total];
    const worst = wrong.indexOf(Math.max(...wrong));
    wrong[worst] = 0;
    return bins[worst].lab;
  });
}
