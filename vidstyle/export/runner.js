/**
 * Runs vidstyle's styles in a browser, with WebGL 2 and nothing else.
 *
 * A plan is the JSON that `vidstyle.gpu.compile.es.es_plan` makes of a style.
 *
 *     import { Runner, missing } from "./runner.js";
 *
 *     const lacks = missing();
 *     if (lacks.length) throw new Error(lacks.join("; "));
 *     const runner = new Runner();
 *     const style = await runner.load(plan);            // compiles while an earlier style goes on
 *     runner.draw(style, video, canvas);                // a picture, a video or a canvas into a canvas
 *     style.values = changed.values;                    // a slider sends numbers only
 *
 * One runner serves any number of styles and canvases: browsers allow few WebGL contexts. It loses nothing
 * with its context: everything is made anew once the browser gives it back, and `onrestored` is called.
 *
 * Pictures are taken as RGB, with the browser's own conversion of video. Stabilization over time and scene
 * cuts are not done here; `restart` says that a new scene begins.
 *
 * @module
 */

/** The version of plans that this runner reads. */
export const FORMAT = 1;

/**
 * @typedef {object} PlanPass
 * @property {number} shader index of its text in `shaders`
 * @property {number} page index of the size at which it runs
 * @property {number[]} writes indices of the images that it writes
 * @property {Object<string, {source?: true, image?: number, measure?: number, texture?: string}>} reads by sampler
 * @property {Object<string, number>} sizes pages whose width and height are a uniform, by its name
 * @property {[string, string, number][]} uniforms name, type and length (0: no array), in the order of `values`
 * @property {number} [measures] the measurement that takes what this pass writes
 */

/**
 * @typedef {object} Plan
 * @property {number} format
 * @property {[number, number]} size width and height for which it was made
 * @property {number} samples
 * @property {string} vertex
 * @property {string[]} shaders
 * @property {number[]} pages
 * @property {{page: number, kind: "working" | "samples" | "result", components: number}[]} images
 * @property {PlanPass[]} passes
 * @property {{step: string, count: number}[]} measures
 * @property {number[]} values
 * @property {Object<string, {size: [number, number, number], components: number, type: string, data: string, film?: Film}>} textures
 * @property {string[]} server what of the style is left out here
 */

/**
 * @typedef {object} Film the constants of `vidstyle.core.film_colors`
 * @property {number} chroma
 * @property {number} side
 * @property {number} bins
 * @property {[number, number]} rounds
 * @property {number} settle
 * @property {number} held
 */

/** @typedef {[number, number]} Size width and height */
/** @typedef {HTMLVideoElement | HTMLImageElement | HTMLCanvasElement | OffscreenCanvas | ImageBitmap | VideoFrame | ImageData} Source */

/**
 * What this browser lacks to run plans: one sentence each, none if nothing is missing.
 * @param {Plan} [plan] the plan in question
 * @returns {string[]}
 */
export function missing(plan) {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) return ["this browser has no WebGL 2, or it is switched off"];
  const lacks = [];
  if (!floatTargets(gl)) lacks.push("this graphics card cannot draw into floating-point textures");
  const most = Math.max(0, ...(plan ? plan.passes.map((pass) => pass.writes.length) : []));
  if (most > gl.getParameter(gl.MAX_DRAW_BUFFERS)) lacks.push("this graphics card cannot draw into enough textures at once");
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return lacks;
}

/**
 * Whether a style's textures can be float32 (32), half floats only (16), or neither (0).
 * @param {WebGL2RenderingContext} gl
 */
function floatTargets(gl) {
  if (gl.getExtension("EXT_color_buffer_float")) return 32;
  return gl.getExtension("EXT_color_buffer_half_float") ? 16 : 0;
}

/**
 * Percentiles of numbers, interpolated between two of them as by `numpy.percentile`.
 * @param {Float32Array} numbers is sorted
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

/** First-order smoothing over time, as by `vidstyle.core.measured.ExponentialSmoother`. */
export class Smoother {
  constructor() {
    /** @type {number[] | null} */
    this.numbers = null;
    /** @type {number | null} */
    this.time = null;
  }

  /**
   * The smoothed numbers after these.
   * @param {number[]} numbers
   * @param {number | null} time in seconds; null for a picture that stands alone
   * @param {number} constant time constant in seconds; 0 follows at once
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

const TO_CONES = [[0.4122214708, 0.5363325363, 0.0514459929], [0.2119034982, 0.6806995451, 0.1073969566], [0.0883024619, 0.2817188376, 0.6299787005]];
const TO_LAB = [[0.210454255, 0.793617785, -0.004072047], [1.977998495, -2.428592205, 0.45059371], [0.025904037, 0.782771766, -0.808675766]];
const FROM_LAB = [[1, 0.3963377774, 0.2158037573], [1, -0.1055613458, -0.0638541728], [1, -0.0894841775, -1.291485548]];
const FROM_CONES = [[4.0767416621, -3.3077115913, 0.2309699292], [-1.2684380046, 2.6097574011, -0.3413193965], [-0.0041960863, -0.7034186147, 1.707614701]];

/** @param {number[][]} matrix @param {number[]} column */
const times = (matrix, column) => matrix.map((row) => row[0] * column[0] + row[1] * column[1] + row[2] * column[2]);

/** OKLab of an sRGB colour within 0..1. @param {number[]} rgb */
function labFromRgb(rgb) {
  const light = rgb.map((value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4));
  return times(TO_LAB, times(TO_CONES, light).map(Math.cbrt));
}

/** The inverse, clipped to 0..1. @param {number[]} lab */
function rgbFromLab(lab) {
  const light = times(FROM_CONES, times(FROM_LAB, lab).map((value) => value ** 3));
  return light.map((value) => Math.min(Math.max(value, 0), 1))
    .map((value) => (value <= 0.0031308 ? value * 12.92 : 1.055 * value ** (1 / 2.4) - 0.055));
}

/** @param {number[]} one @param {number[]} other */
const awayOf = (one, other) => (one[0] - other[0]) ** 2 + (one[1] - other[1]) ** 2 + (one[2] - other[2]) ** 2;

/** The main colours of a film, as by `vidstyle.core.film_colors.FilmColors`. */
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
   * The table of the colours after this picture: rows of OKLab, then of red, green and blue.
   * @param {Uint8Array} texels of a small copy, four a pixel
   * @param {number | null} time in seconds; null for a picture that stands alone
   */
  follow(texels, time) {
    if (time === null) this.restart();
    const { chroma, held } = this.film;
    const bins = this.binned(texels);
    for (const bin of bins) bin.lab = [bin.lab[0], chroma * bin.lab[1], chroma * bin.lab[2]];
    const rounds = this.film.rounds[this.groups ? 1 : 0];
    let groups = this.groups ?? this.seeds(bins);
    for (let round = 0; round < rounds; round++) groups = regrouped(bins, groups);
    this.groups = groups;
    const flat = this.smoother.follow(groups.flat(), time, this.film.settle);
    const wanted = groups.map((_, each) => [flat[3 * each], flat[3 * each + 1] / chroma, flat[3 * each + 2] / chroma]);
    this.shown = wanted.map((lab, each) => (this.shown && awayOf(lab, this.shown[each]) <= held ** 2 ? this.shown[each] : lab));
    const rgb = this.shown.map(rgbFromLab);
    const columns = rgb.map((color) => [...labFromRgb(color), ...color]);
    return Float32Array.from({ length: 6 * this.count }, (_, at) => columns[at % this.count][Math.floor(at / this.count)]);
  }

  /** @private @param {Uint8Array} texels @returns {{lab: number[], weight: number}[]} */
  binned(texels) {
    const { bins } = this.film;
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
      return { lab: [lightness / count, a / count, b / count], weight: Math.sqrt(count) };
    });
  }

  /** @private @param {{lab: number[], weight: number}[]} bins @returns {number[][]} */
  seeds(bins) {
    const away = bins.map(() => Infinity);
    const most = (/** @type {number[]} */ numbers) => bins[numbers.indexOf(Math.max(...numbers))].lab;
    const taken = [most(bins.map((bin) => bin.weight))];
    while (taken.length < this.count) {
      bins.forEach((bin, each) => { away[each] = Math.min(away[each], awayOf(bin.lab, taken[taken.length - 1])); });
      taken.push(most(bins.map((bin, each) => bin.weight * away[each])));
    }
    return taken;
  }
}

/** One round of k-means. @param {{lab: number[], weight: number}[]} bins @param {number[][]} groups */
function regrouped(bins, groups) {
  const sums = groups.map(() => [0, 0, 0, 0]);
  const wrong = bins.map(({ lab, weight }) => {
    let nearest = 0;
    for (let each = 1; each < groups.length; each++) if (awayOf(lab, groups[each]) < awayOf(lab, groups[nearest])) nearest = each;
    [...lab, 1].forEach((part, at) => { sums[nearest][at] += weight * part; });
    return weight * awayOf(lab, groups[nearest]);
  });
  return sums.map(([lightness, a, b, total]) => {
    if (total > 0) return [lightness / total, a / total, b / total];
    const worst = wrong.indexOf(Math.max(...wrong));
    wrong[worst] = 0;
    return bins[worst].lab;
  });
}

/**
 * The size of a picture that is scaled, as by `vidstyle.core.resample.scaled_shape`.
 * @param {Size} size
 * @param {number} factor
 * @returns {Size}
 */
export function scaledSize(size, factor) {
  return /** @type {Size} */ (size.map((side) => Math.max(1, Math.floor(side * factor + 0.5))));
}

/**
 * Which pixels are measured, as by `vidstyle.core.measured.Sampling`.
 * @param {Size} size
 * @param {number} most samples across and down
 * @returns {{stride: number, first: Size, size: Size}}
 */
export function sampling(size, most) {
  const stride = Math.ceil(Math.max(...size) / most);
  const first = size.map((side) => Math.min(Math.floor((stride - 1) / 2), Math.floor((side - 1) / 2)));
  const taken = size.map((side, axis) => Math.ceil((side - first[axis]) / stride));
  return { stride, first: /** @type {Size} */ (first), size: /** @type {Size} */ (taken) };
}

/** A style that a runner has loaded: its plan, the values in use, and what was measured so far. */
export class LoadedStyle {
  /** @param {Plan} plan */
  constructor(plan) {
    this.plan = plan;
    /** The numbers in use; assign others of the same plan to change them from the next picture on. */
    this.values = plan.values;
    /** @type {Smoother[]} */
    this.smoothers = plan.measures.map(() => new Smoother());
    /** The film's own colours, by the names of the textures that they fill. @type {Map<string, FilmColors>} */
    this.films = new Map();
    for (const [name, { size, film }] of Object.entries(plan.textures)) if (film) this.films.set(name, new FilmColors(size[0], film));
    /** @type {Frame | null} */
    this.frame = null;
  }

  /** Takes the next measurements as they are: a new scene or another film begins. */
  restart() {
    for (const smoother of this.smoothers) smoother.time = null;
    for (const colors of this.films.values()) colors.restart();
  }

  /** Frees the textures; the style may be drawn again. */
  release() {
    this.frame?.release();
    this.frame = null;
  }
}

/** Draws styles with one WebGL context. */
export class Runner {
  /**
   * @param {object} [options]
   * @param {boolean} [options.half] half floats even where float32 is to be had
   * @param {() => void} [options.onrestored] called after a lost context has come back: draw again
   */
  constructor(options = {}) {
    this.half = options.half ?? false;
    /** The canvas of the context: what was drawn last, in its upper left corner. */
    this.canvas = document.createElement("canvas");
    this.canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      this.context = null;
    });
    this.canvas.addEventListener("webglcontextrestored", () => {
      this.open();
      options.onrestored?.();
    });
    /** @type {Context | null} null while the context is lost */
    this.context = null;
    /** How many loaded styles need each shader. @type {Map<string, number>} */
    this.users = new Map();
    this.fitting = document.createElement("canvas");
    this.open();
  }

  /** @private */
  open() {
    const options = { alpha: true, antialias: false, depth: false, stencil: false, powerPreference: "high-performance" };
    const gl = /** @type {WebGL2RenderingContext | null} */ (this.canvas.getContext("webgl2", options));
    if (!gl) throw new Error("this browser has no WebGL 2, or it is switched off");
    this.context = new Context(gl, this.half);
  }

  /** The name of the graphics card, as far as the browser tells it. */
  get device() {
    const gl = this.context?.gl;
    if (!gl) return "";
    const info = gl.getExtension("WEBGL_debug_renderer_info");
    return String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  }

  /** Whether there is no graphics card behind it, so that a picture may take seconds. */
  get isSoftware() {
    return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(this.device);
  }

  /**
   * Loads a plan. What the browser can compile at the same time, it does; drawing goes on meanwhile.
   * @param {Plan} plan
   * @returns {Promise<LoadedStyle>}
   */
  async load(plan) {
    if (plan.format !== FORMAT) throw new Error(`the plan has format ${plan.format}, this runner reads ${FORMAT}`);
    for (const text of plan.shaders) {
      this.users.set(text, (this.users.get(text) ?? 0) + 1);
      this.context?.compile(plan.vertex, text);
    }
    while (this.context && !plan.shaders.every((text) => this.context?.isCompiled(text))) {
      await new Promise((done) => setTimeout(done, 10));
    }
    for (const text of plan.shaders) this.context?.program(plan.vertex, text);
    return new LoadedStyle(plan);
  }

  /** Frees a style and the programs that no other one needs. @param {LoadedStyle} style it is not drawn again */
  unload(style) {
    style.release();
    for (const text of style.plan.shaders) {
      const left = (this.users.get(text) ?? 1) - 1;
      this.users.set(text, left);
      if (left > 0) continue;
      this.users.delete(text);
      this.context?.forget(text);
    }
  }

  /**
   * Draws a picture in a style.
   * @param {LoadedStyle} style
   * @param {Source} source
   * @param {HTMLCanvasElement | OffscreenCanvas} [canvas] where to; it keeps its size. Without one, the
   *   result is in the upper left corner of `this.canvas` until the next call.
   * @param {object} [options]
   * @param {number | null} [options.time] presentation time in seconds; null: the picture stands alone
   * @param {Size} [options.size] the size at which to work; else that of the source
   * @returns {Size | null} the size of the result; null if there is no picture yet, or no context now
   */
  draw(style, source, canvas, options = {}) {
    const own = sizeOf(source);
    if (!this.context || this.context.gl.isContextLost() || !own) return null;
    const size = options.size ?? own;
    if (style.frame?.context !== this.context || !style.frame.fits(style, size)) {
      style.release();
      style.frame = new Frame(this.context, style, size);
    }
    style.frame.draw(style, this.fitted(source, own, size), options.time ?? null);
    this.present(style.frame);
    const target = /** @type {CanvasRenderingContext2D | null | undefined} */ (canvas?.getContext("2d"));
    if (canvas && target) target.drawImage(this.canvas, 0, 0, ...size, 0, 0, canvas.width, canvas.height);
    return size;
  }

  /** Frees the context and all that was made with it. */
  release() {
    this.context?.gl.getExtension("WEBGL_lose_context")?.loseContext();
    this.context = null;
  }

  /**
   * The source at the size wanted.
   * @private
   * @param {Source} source @param {Size} own @param {Size} size
   * @returns {Source}
   */
  fitted(source, own, size) {
    if (own[0] === size[0] && own[1] === size[1]) return source;
    if (this.fitting.width !== size[0] || this.fitting.height !== size[1]) [this.fitting.width, this.fitting.height] = size;
    const context = /** @type {CanvasRenderingContext2D} */ (this.fitting.getContext("2d"));
    context.imageSmoothingQuality = "high";
    context.drawImage(/** @type {CanvasImageSource} */ (source), 0, 0, ...size);
    return this.fitting;
  }

  /**
   * Copies the result to the context's own canvas, the right way up.
   * @private
   * @param {Frame} frame
   */
  present(frame) {
    const gl = frame.context.gl;
    const [width, height] = frame.size;
    if (this.canvas.width < width) this.canvas.width = width;
    if (this.canvas.height < height) this.canvas.height = height;
    const { program, locations } = frame.context.program(frame.vertex, COPY);
    gl.useProgram(program);
    if (!locations.has("top")) locations.set("top", gl.getUniformLocation(program, "top"));
    gl.uniform1i(/** @type {WebGLUniformLocation} */ (locations.get("top")), this.canvas.height - 1);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, frame.result);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    // Not by blitFramebuffer, which does not tell every browser that the canvas has changed.
    gl.viewport(0, this.canvas.height - height, width, height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }
}

/**
 * The size of a picture; null while it has none.
 * @param {any} source
 * @returns {Size | null}
 */
function sizeOf(source) {
  const width = source.videoWidth ?? source.naturalWidth ?? source.displayWidth ?? source.width;
  const height = source.videoHeight ?? source.naturalHeight ?? source.displayHeight ?? source.height;
  return width && height ? [width, height] : null;
}

/** What a WebGL context holds for all styles: programs and the textures of assets. */
class Context {
  /** @param {WebGL2RenderingContext} gl @param {boolean} half */
  constructor(gl, half) {
    this.gl = gl;
    const bits = floatTargets(gl);
    if (!bits) throw new Error("this graphics card cannot draw into floating-point textures");
    this.bits = half ? 16 : bits;
    gl.getExtension(this.bits === 16 ? "EXT_color_buffer_half_float" : "EXT_color_buffer_float");
    this.parallel = gl.getExtension("KHR_parallel_shader_compile");
    /** @type {Map<string, {program: WebGLProgram, shader: WebGLShader, locations: Map<string, WebGLUniformLocation | null>, checked: boolean}>} */
    this.programs = new Map();
    /** @type {Map<string, WebGLTexture>} */
    this.textures = new Map();
    /** @type {WebGLShader | null} */
    this.vertex = null;
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.disable(gl.DITHER);
  }

  /**
   * Starts to compile a program, unless it is there.
   * @param {string} vertex @param {string} fragment
   */
  compile(vertex, fragment) {
    if (this.programs.has(fragment)) return;
    const gl = this.gl;
    this.vertex ??= this.shader(gl.VERTEX_SHADER, vertex);
    const program = gl.createProgram();
    const shader = this.shader(gl.FRAGMENT_SHADER, fragment);
    gl.attachShader(program, this.vertex);
    gl.attachShader(program, shader);
    gl.linkProgram(program);
    this.programs.set(fragment, { program, shader, locations: new Map(), checked: false });
  }

  /** @param {number} kind @param {string} text */
  shader(kind, text) {
    const shader = /** @type {WebGLShader} */ (this.gl.createShader(kind));
    this.gl.shaderSource(shader, text);
    this.gl.compileShader(shader);
    return shader;
  }

  /** @param {string} fragment */
  isCompiled(fragment) {
    const found = this.programs.get(fragment);
    if (!found || found.checked || !this.parallel || this.gl.isContextLost()) return true;
    return this.gl.getProgramParameter(found.program, this.parallel.COMPLETION_STATUS_KHR);
  }

  /**
   * A compiled program.
   * @param {string} vertex @param {string} fragment
   */
  program(vertex, fragment) {
    this.compile(vertex, fragment);
    const gl = this.gl;
    const found = /** @type {NonNullable<ReturnType<typeof this.programs.get>>} */ (this.programs.get(fragment));
    if (!found.checked && !gl.isContextLost()) {
      if (!gl.getProgramParameter(found.program, gl.LINK_STATUS)) {
        const reason = gl.getShaderInfoLog(found.shader) || gl.getProgramInfoLog(found.program);
        throw new Error(`the graphics driver refuses a shader: ${reason}`);
      }
      found.checked = true;
    }
    return found;
  }

  /** @param {string} fragment */
  forget(fragment) {
    const found = this.programs.get(fragment);
    if (!found) return;
    this.programs.delete(fragment);
    this.gl.deleteProgram(found.program);
    this.gl.deleteShader(found.shader);
  }

  /**
   * The texture of an asset.
   * @param {string} name @param {Plan} plan
   */
  texture(name, plan) {
    const made = this.textures.get(name);
    if (made) return made;
    const gl = this.gl;
    const { size, components, type, data } = plan.textures[name];
    const bytes = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0)).buffer;
    const half = type === "half";
    const format = components === 1 ? gl.RED : gl.RGBA;
    const internal = components === 1 ? (half ? gl.R16F : gl.R32F) : half ? gl.RGBA16F : gl.RGBA32F;
    const texture = this.newTexture(gl.TEXTURE_2D_ARRAY);
    gl.texImage3D(gl.TEXTURE_2D_ARRAY, 0, internal, ...size, 0, format, half ? gl.HALF_FLOAT : gl.FLOAT,
      half ? new Uint16Array(bytes) : new Float32Array(bytes));
    this.textures.set(name, texture);
    return texture;
  }

  /** The texels of a small copy of a picture. @param {WebGLTexture} picture @param {Size} size @param {Size} small */
  shrunk(picture, size, small) {
    const gl = this.gl;
    const copy = this.newTexture(gl.TEXTURE_2D);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA8, ...small);
    const [from, into] = [gl.createFramebuffer(), gl.createFramebuffer()];
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, from);
    gl.framebufferTexture2D(gl.READ_FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, picture, 0);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, into);
    gl.framebufferTexture2D(gl.DRAW_FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, copy, 0);
    gl.blitFramebuffer(0, 0, ...size, 0, 0, ...small, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, into);
    const texels = new Uint8Array(4 * small[0] * small[1]);
    gl.readPixels(0, 0, ...small, gl.RGBA, gl.UNSIGNED_BYTE, texels);
    for (const each of [from, into]) gl.deleteFramebuffer(each);
    gl.deleteTexture(copy);
    return texels;
  }

  /** A texture whose texels are read as they are, bound. @param {number} target */
  newTexture(target) {
    const gl = this.gl;
    const texture = /** @type {WebGLTexture} */ (gl.createTexture());
    gl.bindTexture(target, texture);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(target, filter, gl.NEAREST);
    for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(target, side, gl.CLAMP_TO_EDGE);
    return texture;
  }
}

/**
 * How many numbers each type of uniform has, and how they are set.
 * @type {Object<string, [number, (gl: WebGL2RenderingContext, at: WebGLUniformLocation, numbers: number[]) => void]>}
 */
const UNIFORMS = {
  bool: [1, (gl, at, numbers) => gl.uniform1iv(at, numbers)],
  int: [1, (gl, at, numbers) => gl.uniform1iv(at, numbers)],
  uint: [1, (gl, at, numbers) => gl.uniform1uiv(at, numbers)],
  ivec2: [2, (gl, at, numbers) => gl.uniform2iv(at, numbers)],
  float: [1, (gl, at, numbers) => gl.uniform1fv(at, numbers)],
  vec2: [2, (gl, at, numbers) => gl.uniform2fv(at, numbers)],
  vec3: [3, (gl, at, numbers) => gl.uniform3fv(at, numbers)],
  vec4: [4, (gl, at, numbers) => gl.uniform4fv(at, numbers)],
  mat3: [9, (gl, at, numbers) => gl.uniformMatrix3fv(at, false, numbers)],
};

/** The textures of one style for pictures of one size. */
class Frame {
  /** @param {Context} context @param {LoadedStyle} style @param {Size} size of the picture */
  constructor(context, style, size) {
    const gl = context.gl;
    this.context = context;
    this.size = size;
    this.pages = pagesOf(style, size);
    this.source = context.newTexture(gl.TEXTURE_2D);
    this.measured = style.plan.measures.map(() => context.newTexture(gl.TEXTURE_2D));
    /** @type {{texture: WebGLTexture, size: Size}[]} */
    this.images = style.plan.images.map(({ page, kind, components }) => {
      const own = kind === "samples" ? sampling(this.pages[page], style.plan.samples).size : this.pages[page];
      const texture = context.newTexture(gl.TEXTURE_2D);
      gl.texStorage2D(gl.TEXTURE_2D, 1, this.format(kind, components), ...own);
      return { texture, size: own };
    });
    this.targets = style.plan.passes.map((pass) => this.framebuffer(pass.writes));
    this.vertex = style.plan.vertex;
    this.result = this.images[style.plan.images.findIndex((image) => image.kind === "result")].texture;
  }

  /** @param {LoadedStyle} style @param {Size} size */
  fits(style, size) {
    return String(pagesOf(style, size)) === String(this.pages);
  }

  /** @param {string} kind @param {number} components */
  format(kind, components) {
    const gl = this.context.gl;
    if (kind === "result") return gl.RGBA8;
    const half = [gl.RG16F, gl.RG16F, gl.RGBA16F]; // luma is the sum of two
    return (this.context.bits === 16 ? half : [gl.R32F, gl.RG32F, gl.RGBA32F])[Math.min(components, 3) - 1];
  }

  /** @param {number[]} writes */
  framebuffer(writes) {
    const gl = this.context.gl;
    const made = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, made);
    const points = writes.map((_, number) => gl.COLOR_ATTACHMENT0 + number);
    writes.forEach((image, number) => {
      gl.framebufferTexture2D(gl.FRAMEBUFFER, points[number], gl.TEXTURE_2D, this.images[image].texture, 0);
    });
    gl.drawBuffers(points);
    return made;
  }

  /** @param {LoadedStyle} style @param {Source} source @param {number | null} time */
  draw(style, source, time) {
    const gl = this.context.gl;
    gl.bindTexture(gl.TEXTURE_2D, this.source);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, /** @type {TexImageSource} */ (source));
    this.takeColors(style, time);
    let at = this.pages.length - 1;
    const ends = style.plan.passes.map((pass) => (at += countOf(pass)));
    style.plan.passes.forEach((pass, number) => {
      this.pass(style, pass, this.targets[number], ends[number] - countOf(pass), Math.floor((time ?? 0) * 1000 + 0.5));
      if (pass.measures !== undefined) this.measure(style, pass, time, at);
    });
  }

  /** Fills the tables with the film's own colours. @param {LoadedStyle} style @param {number | null} time */
  takeColors(style, time) {
    const gl = this.context.gl;
    for (const [name, colors] of style.films) {
      const [width, height] = sampling(this.size, colors.film.side).size;
      const texels = this.context.shrunk(this.source, this.size, [width, height]);
      gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.context.texture(name, style.plan));
      gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, 0, 0, 0, colors.count, 6, 1, gl.RED, gl.FLOAT, colors.follow(texels, time));
    }
  }

  /**
   * @param {LoadedStyle} style @param {PlanPass} pass @param {WebGLFramebuffer} target @param {number} at in the values
   * @param {number} moment of the frame, in whole milliseconds
   */
  pass(style, pass, target, at, moment) {
    const { plan, values } = style;
    const gl = this.context.gl;
    const { program, locations } = this.context.program(plan.vertex, plan.shaders[pass.shader]);
    /** @param {string} name @param {string} type @param {number[]} numbers */
    const set = (name, type, numbers) => {
      if (!locations.has(name)) locations.set(name, gl.getUniformLocation(program, name));
      const location = locations.get(name);
      if (location) UNIFORMS[type][1](gl, location, numbers);
    };
    gl.useProgram(program);
    const { stride, first } = pass.measures === undefined ? WHOLE : sampling(this.pages[pass.page], plan.samples);
    set("origin", "ivec2", first);
    set("stride", "ivec2", [stride, stride]);
    set("moment", "uint", [moment]);
    set("halved", "bool", [Number(this.context.bits === 16)]);
    for (const [name, page] of Object.entries(pass.sizes)) set(name, "ivec2", this.pages[page]);
    for (const [name, type, length] of pass.uniforms) {
      const end = at + UNIFORMS[type][0] * (length || 1);
      set(name, type, values.slice(at, end));
      at = end;
    }
    Object.entries(pass.reads).forEach(([name, what], unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      set(name, "int", [unit]);
      const size = this.bind(plan, what);
      set(`${name}_origin`, "ivec2", [0, 0]);
      if (size) set(`${name}_last`, "ivec2", size.map((side) => side - 1));
    });
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    gl.viewport(0, 0, ...this.images[pass.writes[0]].size);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /**
   * Binds a texture to the active unit; the size of a picture.
   * @param {Plan} plan @param {PlanPass["reads"][string]} what
   */
  bind(plan, what) {
    const gl = this.context.gl;
    if (what.texture !== undefined) {
      gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.context.texture(what.texture, plan));
      return null;
    }
    if (what.measure !== undefined) {
      gl.bindTexture(gl.TEXTURE_2D, this.measured[what.measure]);
      return null;
    }
    gl.bindTexture(gl.TEXTURE_2D, what.image === undefined ? this.source : this.images[what.image].texture);
    return what.image === undefined ? this.size : this.images[what.image].size;
  }

  /** @param {LoadedStyle} style @param {PlanPass} pass @param {number | null} time @param {number} at of the first measurement */
  measure(style, pass, time, at) {
    const gl = this.context.gl;
    const { measures } = style.plan;
    const which = /** @type {number} */ (pass.measures);
    for (const each of measures.slice(0, which)) at += 1 + each.count;
    const [constant, ...percentages] = style.values.slice(at, at + 1 + measures[which].count);
    const [width, height] = this.images[pass.writes[0]].size;
    const texels = new Float32Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, texels);
    const luma = Float32Array.from({ length: width * height }, (_, number) => texels[4 * number] + texels[4 * number + 1]);
    const found = percentiles(luma, percentages);
    const numbers = style.smoothers[which].follow(found, time, constant);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.measured[which]);
    const four = [0, 1, 2, 3].map((each) => numbers[Math.min(each, numbers.length - 1)]);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, 1, 1, 0, gl.RGBA, gl.FLOAT, new Float32Array(four));
  }

  release() {
    const gl = this.context.gl;
    for (const texture of [this.source, ...this.measured, ...this.images.map((image) => image.texture)]) gl.deleteTexture(texture);
    for (const target of this.targets) gl.deleteFramebuffer(target);
  }
}

/** Copies a picture to the canvas, whose first row is the lowest. */
const COPY = `#version 300 es
precision highp float;
precision highp int;
uniform sampler2D picture;
uniform int top;
out vec4 color;
void main() {
    color = texelFetch(picture, ivec2(int(gl_FragCoord.x), top - int(gl_FragCoord.y)), 0);
}
`;

/** @type {{stride: number, first: Size}} */
const WHOLE = { stride: 1, first: [0, 0] };

/** How many of the values are a pass's. @param {PlanPass} pass */
function countOf(pass) {
  return pass.uniforms.reduce((sum, [, type, length]) => sum + UNIFORMS[type][0] * (length || 1), 0);
}

/**
 * The sizes at which passes run.
 * @param {LoadedStyle} style @param {Size} size of the picture
 * @returns {Size[]}
 */
function pagesOf({ plan, values }, size) {
  const pages = [size];
  plan.pages.slice(1).forEach((madeOf, number) => pages.push(scaledSize(pages[madeOf], values[number])));
  return pages;
}
