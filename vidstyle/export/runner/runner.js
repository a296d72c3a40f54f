/**
 * Runs vidstyle styles in a browser with WebGL 2, without other dependencies.
 *
 * A plan is the JSON form of a style from `vidstyle.gpu.compile.es.es_plan`.
 *
 *     import { Runner, missing } from "./runner.js";
 *
 *     const lacks = missing();
 *     if (lacks.length) throw new Error(lacks.join("; "));
 *     const runner = new Runner();
 *     const style = await runner.load(plan);            // compiles in the background
 *     runner.draw(style, video, canvas);                // from a picture, a video or a canvas
 *     style.values = changed.values;                    // a slider changes numbers only
 *
 * Use one runner for all styles and canvases, since browsers limit the number of WebGL contexts. After a lost
 * context, the runner restores all resources and calls `onrestored`.
 *
 * The browser converts video to RGB. Temporal smoothing and scene detection are not supported; call `restart` at
 * the start of a new scene.
 *
 * @module
 */

import { Context, floatTargets } from "./context.js";
import { Frame } from "./frame.js";
import { FilmColors, Smoother } from "./measured.js";

/** Number of pixels of a pass that are drawn at once without a GPU: at most 0.8 s in `ink` on two busy cores. */
const MAX_PIXELS_AT_ONCE = 120_000;

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
 * @property {number} [measures] the measurement of the output of this pass
 */

/**
 * @typedef {object} Plan
 * @property {number} format
 * @property {[number, number]} size width and height of its pictures
 * @property {number} samples
 * @property {string} vertex
 * @property {string[]} shaders
 * @property {number[]} pages
 * @property {number[]} borders
 * @property {{page: number, kind: "working" | "samples" | "result", components: number}[]} images
 * @property {PlanPass[]} passes
 * @property {{step: string, count: number}[]} measures
 * @property {number[]} values
 * @property {Object<string, {size: [number, number, number], components: number, type: string, data: string, film?: Film}>} textures
 * @property {string[]} server the features that only the server supports
 */

/**
 * @typedef {object} Film the constants of `vidstyle.core.film_colors`
 * @property {number} chroma
 * @property {[number, number, number, number]} skin
 * @property {number} side
 * @property {number} bins
 * @property {[number, number]} rounds
 * @property {number} settle
 * @property {number} held
 */

/** @typedef {[number, number]} Size width and height */
/** @typedef {HTMLVideoElement | HTMLImageElement | HTMLCanvasElement | OffscreenCanvas | ImageBitmap | VideoFrame | ImageData} Source */

/**
 * Returns the features for running plans that this browser lacks, one sentence each.
 * @param {Plan} [plan] the plan in question
 * @returns {string[]}
 */
export function missing(plan) {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) return ["this browser does not support WebGL 2, or it is disabled"];
  const lacks = [];
  if (!floatTargets(gl)) lacks.push("this GPU cannot render to floating-point textures");
  const most = Math.max(0, ...(plan ? plan.passes.map((pass) => pass.writes.length) : []));
  if (most > gl.getParameter(gl.MAX_DRAW_BUFFERS)) lacks.push("this GPU cannot render to enough textures at once");
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return lacks;
}

/** A loaded style: its plan, current values and measurements. */
export class LoadedStyle {
  /** @param {Plan} plan */
  constructor(plan) {
    this.plan = plan;
    /** The current values; assign values of the same plan to change the next picture. */
    this.values = plan.values;
    /** @type {Smoother[]} */
    this.smoothers = plan.measures.map(() => new Smoother());
    /** Film colours by texture name. @type {Map<string, FilmColors>} */
    this.films = new Map();
    for (const [name, { size, film }] of Object.entries(plan.textures)) if (film) this.films.set(name, new FilmColors(size[0], film));
    /** @type {Frame | null} */
    this.frame = null;
  }

  /** Resets smoothing: a new scene or another film begins. */
  restart() {
    for (const smoother of this.smoothers) smoother.time = null;
    for (const colors of this.films.values()) colors.restart();
  }

  /** Releases the textures; the style can still be drawn again. */
  release() {
    this.frame?.release();
    this.frame = null;
  }
}

/** Draws styles with one WebGL context. */
export class Runner {
  /**
   * @param {object} [options]
   * @param {boolean} [options.half] whether to use half floats even if float32 is supported
   * @param {() => void} [options.onrestored] is called when a lost context is restored; draw again
   */
  constructor(options = {}) {
    this.half = options.half ?? false;
    /** The canvas of the context; it holds the last picture in its upper left corner. */
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
    /** Number of loaded styles that use each shader. @type {Map<string, number>} */
    this.users = new Map();
    this.fitting = document.createElement("canvas");
    this.open();
  }

  /** @private */
  open() {
    const options = { alpha: true, antialias: false, depth: false, stencil: false, powerPreference: "high-performance" };
    const gl = /** @type {WebGL2RenderingContext | null} */ (this.canvas.getContext("webgl2", options));
    if (!gl) throw new Error("this browser does not support WebGL 2, or it is disabled");
    this.context = new Context(gl, this.half);
  }

  /** The name of the GPU, as reported by the browser, without API, numbers and vendor. */
  get device() {
    const [vendor, name] = this.renderer.replace(/^ANGLE \((.*)\)$/, "$1").split(", ");
    return (name ?? vendor)
      .replace(/^Vulkan [\d.]+ \((.*)\)$/, "$1")
      .replace(/^ANGLE .*?: /, "")
      .replace(/ \(0x[0-9a-f]+\)| Direct3D.*$/gi, "");
  }

  /** @private */
  get renderer() {
    const gl = this.context?.gl;
    if (!gl) return "";
    const info = gl.getExtension("WEBGL_debug_renderer_info");
    return String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  }

  /** Whether rendering is done in software, so that a picture may take seconds. */
  get isSoftware() {
    return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(this.renderer);
  }

  /**
   * Loads a plan. The browser compiles shaders in parallel if it can; drawing continues.
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
   * @param {Size} [options.size] the working size; default: the size of the source
   * @returns {Size | null} the size of the result; null if there is no picture yet, or no context now
   */
  draw(style, source, canvas, options = {}) {
    const begun = this.begin(style, source, options);
    if (!begun) return null;
    for (const _ of begun.parts);
    this.present(begun.frame);
    const { size } = begun.frame;
    const target = /** @type {CanvasRenderingContext2D | null | undefined} */ (canvas?.getContext("2d"));
    if (canvas && target) target.drawImage(this.canvas, 0, 0, ...size, 0, 0, canvas.width, canvas.height);
    return size;
  }

  /**
   * Draws a picture like `draw` without a canvas, in parts, between which the page stays responsive without a GPU.
   * @param {LoadedStyle} style it is not drawn otherwise meanwhile
   * @param {Source} source
   * @param {object} [options]
   * @param {number | null} [options.time]
   * @param {Size} [options.size]
   * @param {() => boolean} [options.isOutdated] whether the picture is no longer wanted
   * @param {(part: number) => void} [options.onpart] is called after each part with the fraction that is drawn
   * @returns {Promise<Size | null>} null also if it is no longer wanted
   */
  async drawInParts(style, source, options = {}) {
    const rows = Math.ceil(MAX_PIXELS_AT_ONCE / (options.size ?? sizeOf(source) ?? [1])[0]);
    const begun = this.begin(style, source, options, rows);
    if (!begun) return null;
    const { frame, parts } = begun;
    const total = frame.countParts(style, rows);
    let drawn = 0;
    for (const _ of parts) {
      await frame.context.finish();
      if (options.isOutdated?.() || style.frame !== frame || frame.context !== this.context || frame.context.gl.isContextLost()) return null;
      options.onpart?.(++drawn / total);
    }
    this.present(frame);
    return frame.size;
  }

  /**
   * Returns the frame of a style for this size, and its drawing in parts; null if there is no picture yet, or no context now.
   * @private
   * @param {LoadedStyle} style @param {Source} source
   * @param {{time?: number | null, size?: Size}} options
   * @param {number} [rows] of a pass that are one part
   */
  begin(style, source, options, rows) {
    const own = sizeOf(source);
    if (!this.context || this.context.gl.isContextLost() || !own) return null;
    const size = options.size ?? own;
    if (style.frame?.context !== this.context || !style.frame.fits(style, size)) {
      style.release();
      style.frame = new Frame(this.context, style, size);
    }
    return { frame: style.frame, parts: style.frame.parts(style, this.resize(source, own, size), options.time ?? null, rows) };
  }

  /** Frees the context and all that was made with it. */
  release() {
    this.context?.gl.getExtension("WEBGL_lose_context")?.loseContext();
    this.context = null;
  }

  /**
   * Returns the source resized to this size.
   * @private
   * @param {Source} source @param {Size} own @param {Size} size
   * @returns {Source}
   */
  resize(source, own, size) {
    if (own[0] === size[0] && own[1] === size[1]) return source;
    if (this.fitting.width !== size[0] || this.fitting.height !== size[1]) [this.fitting.width, this.fitting.height] = size;
    const context = /** @type {CanvasRenderingContext2D} */ (this.fitting.getContext("2d"));
    context.imageSmoothingQuality = "high";
    context.drawImage(/** @type {CanvasImageSource} */ (source), 0, 0, ...size);
    return this.fitting;
  }

  /**
   * Copies the result to the canvas of the context, flipped vertically.
   * @private
   * @param {Frame} frame
   */
  present(frame) {
    const gl = frame.context.gl;
    const [width, height] = frame.size;
    if (this.canvas.width < width) this.canvas.width = width;
    if (this.canvas.height < height) this.canvas.height = height;
    const { program, locations } = frame.context.program(frame.vertex, COPY_SHADER);
    gl.useProgram(program);
    if (!locations.has("top")) locations.set("top", gl.getUniformLocation(program, "top"));
    gl.uniform1i(/** @type {WebGLUniformLocation} */ (locations.get("top")), this.canvas.height - 1);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, frame.result);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    // blitFramebuffer does not mark the canvas as changed in every browser.
    gl.viewport(0, this.canvas.height - height, width, height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }
}

/**
 * Returns the size of a picture; null if it has none yet.
 * @param {any} source
 * @returns {Size | null}
 */
function sizeOf(source) {
  const width = source.videoWidth ?? source.naturalWidth ?? source.displayWidth ?? source.width;
  const height = source.videoHeight ?? source.naturalHeight ?? source.displayHeight ?? source.height;
  return width && height ? [width, height] : null;
}

/** Copies a picture to the canvas, whose first row is at the bottom. */
const COPY_SHADER = `#version 300 es
precision highp float;
precision highp int;
uniform sampler2D picture;
uniform int top;
out vec4 color;
void main() {
    color = texelFetch(picture, ivec2(int(gl_FragCoord.x), top - int(gl_FragCoord.y)), 0);
}
`;
