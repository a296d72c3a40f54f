// Resources shared by all styles of a WebGL context: programs and asset textures.

/** @typedef {import("./runner.js").Plan} Plan */
/** @typedef {import("./runner.js").Size} Size */

/**
 * Returns the largest supported float render target: 32, 16 or 0 bits.
 * @param {WebGL2RenderingContext} gl
 */
export function floatTargets(gl) {
  if (gl.getExtension("EXT_color_buffer_float")) return 32;
  return gl.getExtension("EXT_color_buffer_half_float") ? 16 : 0;
}

/** Resources shared by all styles: programs and asset textures. */
export class Context {
  /** @param {WebGL2RenderingContext} gl @param {boolean} half */
  constructor(gl, half) {
    this.gl = gl;
    const bits = floatTargets(gl);
    if (!bits) throw new Error("this GPU cannot render to floating-point textures");
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
   * Starts to compile a program, unless it exists.
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

  /** Resolves once the GPU has finished all commands. */
  async finish() {
    const gl = this.gl;
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    do await new Promise((done) => setTimeout(done)); while (fence && gl.clientWaitSync(fence, 0, 0) === gl.TIMEOUT_EXPIRED);
    gl.deleteSync(fence);
  }

  /**
   * Returns a compiled program.
   * @param {string} vertex @param {string} fragment
   */
  program(vertex, fragment) {
    this.compile(vertex, fragment);
    const gl = this.gl;
    const found = /** @type {NonNullable<ReturnType<typeof this.programs.get>>} */ (this.programs.get(fragment));
    if (!found.checked && !gl.isContextLost()) {
      if (!gl.getProgramParameter(found.program, gl.LINK_STATUS)) {
        const reason = gl.getShaderInfoLog(found.shader) || gl.getProgramInfoLog(found.program);
        throw new Error(`the graphics driver rejected a shader: ${reason}`);
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
   * Returns the texture of an asset.
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

  /**
   * Returns the sampled texels of a picture.
   * @param {WebGLTexture} picture @param {{stride: number, first: Size, size: Size}} sampling
   */
  sampled(picture, { stride, first, size: small }) {
    const gl = this.gl;
    // A copied texel is the one in the middle of its part of the picture. With an even stride the middle is a border
    // of two texels: parts that are a little narrower have it within the first of them.
    const [left, top] = first.map((each) => each - Math.floor((stride - 1) / 2));
    const [width, height] = small.map((count) => stride * count - ((stride + 1) % 2));
    const copy = this.newTexture(gl.TEXTURE_2D);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA8, ...small);
    const [from, into] = [gl.createFramebuffer(), gl.createFramebuffer()];
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, from);
    gl.framebufferTexture2D(gl.READ_FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, picture, 0);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, into);
    gl.framebufferTexture2D(gl.DRAW_FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, copy, 0);
    gl.blitFramebuffer(left, top, left + width, top + height, 0, 0, ...small, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, into);
    const texels = new Uint8Array(4 * small[0] * small[1]);
    gl.readPixels(0, 0, ...small, gl.RGBA, gl.UNSIGNED_BYTE, texels);
    for (const each of [from, into]) gl.deleteFramebuffer(each);
    gl.deleteTexture(copy);
    return texels;
  }

  /** Creates and binds a texture without filtering. @param {number} target */
  newTexture(target) {
    const gl = this.gl;
    const texture = /** @type {WebGLTexture} */ (gl.createTexture());
    gl.bindTexture(target, texture);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(target, filter, gl.NEAREST);
    for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(target, side, gl.CLAMP_TO_EDGE);
    return texture;
  }
}
