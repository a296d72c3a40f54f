// Rendering of a style for one picture size: its textures and passes.

import { percentiles } from "./measured.js";

/** @typedef {import("./context.js").Context} Context */
/** @typedef {import("./runner.js").LoadedStyle} LoadedStyle */
/** @typedef {import("./runner.js").Plan} Plan */
/** @typedef {import("./runner.js").PlanPass} PlanPass */
/** @typedef {import("./runner.js").Size} Size */
/** @typedef {import("./runner.js").Source} Source */

/**
 * Returns the size of a scaled picture, as in `vidstyle.core.resample.scaled_shape`.
 * @param {Size} size
 * @param {number} factor
 * @param {number} border pixels that are then added on every side
 * @returns {Size}
 */
export function scaledSize(size, factor, border) {
  return /** @type {Size} */ (size.map((side) => Math.max(1, Math.floor(side * factor + 0.5)) + 2 * border));
}

/**
 * Returns which pixels are measured, as in `vidstyle.core.sampling.Sampling`.
 * @param {Size} size
 * @param {number} most maximum number of samples in each direction
 * @returns {{stride: number, first: Size, size: Size}}
 */
export function sampling(size, most) {
  const stride = Math.ceil(Math.max(...size) / most);
  const first = size.map((side) => Math.min(Math.floor((stride - 1) / 2), Math.floor((side - 1) / 2)));
  const taken = size.map((side, axis) => Math.ceil((side - first[axis]) / stride));
  return { stride, first: /** @type {Size} */ (first), size: /** @type {Size} */ (taken) };
}

/**
 * The number of components of each uniform type, and its setter.
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
export class Frame {
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

  /**
   * Draws a picture; pauses after each part of the work.
   * @param {LoadedStyle} style @param {Source} source @param {number | null} time
   * @param {number} [rows] of a pass that are drawn at once
   */
  *parts(style, source, time, rows = Infinity) {
    const gl = this.context.gl;
    gl.bindTexture(gl.TEXTURE_2D, this.source);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, /** @type {TexImageSource} */ (source));
    this.takeColors(style, time);
    let at = this.pages.length - 1;
    const ends = style.plan.passes.map((pass) => (at += countOf(pass)));
    for (const [number, pass] of style.plan.passes.entries()) {
      const [width, height] = this.images[pass.writes[0]].size;
      for (let top = 0; top < height; top += rows) {
        this.pass(style, pass, this.targets[number], ends[number] - countOf(pass), Math.floor((time ?? 0) * 1000 + 0.5), [0, top, width, Math.min(rows, height - top)]);
        yield;
      }
      if (pass.measures !== undefined) this.measure(style, pass, time, at);
    }
  }

  /** Returns the number of parts in which a frame is drawn. @param {LoadedStyle} style @param {number} rows of a pass that are one part */
  countParts(style, rows) {
    return style.plan.passes.reduce((count, { writes }) => count + Math.ceil(this.images[writes[0]].size[1] / rows), 0);
  }

  /** Updates the tables of film colours. @param {LoadedStyle} style @param {number | null} time */
  takeColors(style, time) {
    const gl = this.context.gl;
    for (const [name, colors] of style.films) {
      const texels = this.context.sampled(this.source, sampling(this.size, colors.film.side));
      gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.context.texture(name, style.plan));
      gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, 0, 0, 0, colors.count, 6, 1, gl.RED, gl.FLOAT, colors.follow(texels, time));
    }
  }

  /**
   * @param {LoadedStyle} style @param {PlanPass} pass @param {WebGLFramebuffer} target @param {number} at index of its first value
   * @param {number} moment the time of the frame in whole milliseconds
   * @param {[number, number, number, number]} part to draw: left, top, width and height
   */
  pass(style, pass, target, at, moment, part) {
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
    const { stride, first } = pass.measures === undefined ? FULL_SAMPLING : sampling(this.pages[pass.page], plan.samples);
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
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(...part);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.disable(gl.SCISSOR_TEST);
  }

  /**
   * Binds a texture to the active unit; returns the size of a picture.
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

  /** @param {LoadedStyle} style @param {PlanPass} pass @param {number | null} time @param {number} at index of the first measurement */
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

/** @type {{stride: number, first: Size}} */
const FULL_SAMPLING = { stride: 1, first: [0, 0] };

/** Returns the number of values of a pass. @param {PlanPass} pass */
function countOf(pass) {
  return pass.uniforms.reduce((sum, [, type, length]) => sum + UNIFORMS[type][0] * (length || 1), 0);
}

/**
 * Returns the sizes at which passes run.
 * @param {LoadedStyle} style @param {Size} size of the picture
 * @returns {Size[]}
 */
function pagesOf({ plan, values }, size) {
  const pages = [size];
  plan.pages.slice(1).forEach((madeOf, number) => {
    pages.push(scaledSize(pages[madeOf], values[number], plan.borders[number + 1]));
  });
  return pages;
}
