// Thin helpers over WebGL2: a context, programs with their uniforms by name, textures of plain data, targets.

/** Why there is no picture, as a sentence for people. */
export class RenderError extends Error {}

/**
 * @param {HTMLCanvasElement} canvas
 * @returns {WebGL2RenderingContext}
 */
export function contextOf(canvas) {
  const gl = /** @type {WebGL2RenderingContext | null} */ (
    canvas.getContext('webgl2', {
      alpha: true, // as textures that are drawn into: shaders are compiled for one form of target
      antialias: false,
      depth: false,
      stencil: false,
      powerPreference: 'high-performance',
      preserveDrawingBuffer: false,
    })
  );
  if (!gl)
    throw new RenderError(
      'This browser has no WebGL2, which the picture is drawn with. Try a newer browser, or ' +
        'turn on hardware acceleration.',
    );
  return gl;
}

const PREAMBLE = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;
precision highp sampler2DArray;
precision highp usampler2DArray;
precision highp sampler2DArrayShadow;
`;

/** A program, with the locations of its uniforms and a texture unit for each of its samplers. */
export class Program {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {string} vertex
   * @param {string} fragment
   * @param {Record<string, string | number>} [defines]
   */
  constructor(gl, vertex, fragment, defines = {}) {
    this.gl = gl;
    const head =
      PREAMBLE +
      Object.entries(defines)
        .map(([name, value]) => `#define ${name} ${value}\n`)
        .join('');
    this.program = /** @type {WebGLProgram} */ (gl.createProgram());
    this.shaders = [
      [gl.VERTEX_SHADER, vertex],
      [gl.FRAGMENT_SHADER, fragment],
    ].map(([type, source]) => {
      const shader = /** @type {WebGLShader} */ (gl.createShader(/** @type {number} */ (type)));
      gl.shaderSource(shader, head + source);
      gl.compileShader(shader);
      gl.attachShader(this.program, shader);
      return shader;
    });
    gl.linkProgram(this.program);
    /** @type {Map<string, {location: WebGLUniformLocation, type: number, unit: number}> | null} */
    this.uniforms = null;
  }

  /** Resolves when the compiler, which works beside the page where the browser lets it, has come to its end. */
  async ready() {
    const { gl } = this;
    const extension = gl.getExtension('KHR_parallel_shader_compile');
    const done = () => gl.getProgramParameter(this.program, /** @type {any} */ (extension).COMPLETION_STATUS_KHR);
    while (extension && !gl.isContextLost() && !done()) await new Promise((go) => setTimeout(go, 10));
    this.linked();
  }

  /** Waits for the compiler. */
  linked() {
    const { gl } = this;
    if (this.uniforms) return this.uniforms;
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS) && !gl.isContextLost()) {
      const why = [gl.getProgramInfoLog(this.program), ...this.shaders.map((shader) => gl.getShaderInfoLog(shader))];
      throw new RenderError(`This browser's graphics driver refuses a shader: ${why.filter(Boolean).join(' ')}`);
    }
    for (const shader of this.shaders) gl.deleteShader(shader);
    this.uniforms = new Map();
    let unit = 0;
    const count = gl.getProgramParameter(this.program, gl.ACTIVE_UNIFORMS) || 0;
    for (let i = 0; i < count; ++i) {
      const info = /** @type {WebGLActiveInfo} */ (gl.getActiveUniform(this.program, i));
      const location = /** @type {WebGLUniformLocation} */ (gl.getUniformLocation(this.program, info.name));
      const name = info.name.replace(/\[0\]$/, '');
      this.uniforms.set(name, { location, type: info.type, unit: isSampler(gl, info.type) ? unit++ : -1 });
    }
    return this.uniforms;
  }

  /**
   * Uses the program with these values. What a variant of the program does not read is left out silently.
   * @param {Record<string, any>} values numbers, arrays of them, booleans, and textures as {target, texture}
   */
  use(values) {
    const { gl } = this;
    const uniforms = this.linked();
    gl.useProgram(this.program);
    for (const [name, value] of Object.entries(values)) {
      const uniform = uniforms.get(name);
      if (!uniform) continue;
      if (uniform.unit >= 0) {
        gl.activeTexture(gl.TEXTURE0 + uniform.unit);
        gl.bindTexture(value.target, value.texture);
        gl.uniform1i(uniform.location, uniform.unit);
      } else {
        setUniform(gl, uniform, value);
      }
    }
  }

  /** Sets one uniform of the program in use. */
  set(/** @type {string} */ name, /** @type {any} */ value) {
    const uniform = this.linked().get(name);
    if (uniform) setUniform(this.gl, uniform, value);
  }

  dispose() {
    this.gl.deleteProgram(this.program);
  }
}

function isSampler(/** @type {WebGL2RenderingContext} */ gl, /** @type {number} */ type) {
  return [
    gl.SAMPLER_2D,
    gl.SAMPLER_2D_ARRAY,
    gl.UNSIGNED_INT_SAMPLER_2D,
    gl.UNSIGNED_INT_SAMPLER_2D_ARRAY,
    gl.SAMPLER_2D_ARRAY_SHADOW,
  ].includes(type);
}

function setUniform(
  /** @type {WebGL2RenderingContext} */ gl,
  /** @type {{location: WebGLUniformLocation, type: number}} */ uniform,
  /** @type {any} */ value,
) {
  const { location, type } = uniform;
  switch (type) {
    case gl.FLOAT:
      return gl.uniform1f(location, value);
    case gl.FLOAT_VEC2:
      return gl.uniform2fv(location, value);
    case gl.FLOAT_VEC3:
      return gl.uniform3fv(location, value);
    case gl.FLOAT_VEC4:
      return gl.uniform4fv(location, value);
    case gl.FLOAT_MAT4:
      return gl.uniformMatrix4fv(location, false, value);
    case gl.INT:
    case gl.BOOL:
      return gl.uniform1i(location, Number(value));
    case gl.INT_VEC2:
      return gl.uniform2iv(location, value);
    case gl.UNSIGNED_INT:
      return gl.uniform1ui(location, value);
    default:
      throw new RenderError(`A uniform has the unexpected type ${type}.`);
  }
}

/**
 * @typedef {{target: number, texture: WebGLTexture, width: number, height: number}} Texture
 */

/**
 * A texture without mip levels that is read texel by texel.
 * @param {WebGL2RenderingContext} gl
 * @param {number} format sized
 * @param {number} width
 * @param {number} height
 * @returns {Texture}
 */
export function texture2d(gl, format, width, height) {
  const texture = makeTexture(gl, gl.TEXTURE_2D);
  gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
  return { target: gl.TEXTURE_2D, texture, width, height };
}

/** As texture2d, with layers. */
export function textureArray(
  /** @type {WebGL2RenderingContext} */ gl,
  /** @type {number} */ format,
  /** @type {number} */ width,
  /** @type {number} */ height,
  /** @type {number} */ layers,
) {
  const texture = makeTexture(gl, gl.TEXTURE_2D_ARRAY);
  gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, format, width, height, layers);
  return { target: gl.TEXTURE_2D_ARRAY, texture, width, height, layers };
}

function makeTexture(/** @type {WebGL2RenderingContext} */ gl, /** @type {number} */ target) {
  const texture = /** @type {WebGLTexture} */ (gl.createTexture());
  gl.bindTexture(target, texture);
  gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
  gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  gl.texParameteri(target, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texParameteri(target, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  return texture;
}

/**
 * A framebuffer with a colour texture, a depth texture, or both.
 * @param {WebGL2RenderingContext} gl
 * @param {Texture | null} colour
 * @param {Texture | null} depth
 */
export function framebuffer(gl, colour, depth) {
  const made = /** @type {WebGLFramebuffer} */ (gl.createFramebuffer());
  gl.bindFramebuffer(gl.FRAMEBUFFER, made);
  if (colour) gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, colour.texture, 0);
  if (depth) gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, depth.texture, 0);
  return made;
}

/** A texture that is drawn into, of the size that was asked for last. */
export class Target {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {number} format sized
   */
  constructor(gl, format) {
    this.gl = gl;
    this.format = format;
    /** @type {{texture: Texture, framebuffer: WebGLFramebuffer} | null} */
    this.made = null;
  }

  /** Of this size; what it showed may be gone. */
  sized(/** @type {number} */ width, /** @type {number} */ height) {
    if (this.made?.texture.width === width && this.made.texture.height === height) return this.made;
    this.dispose();
    const texture = texture2d(this.gl, this.format, width, height);
    return (this.made = { texture, framebuffer: framebuffer(this.gl, texture, null) });
  }

  dispose() {
    if (!this.made) return;
    this.gl.deleteFramebuffer(this.made.framebuffer);
    this.gl.deleteTexture(this.made.texture.texture);
    this.made = null;
  }
}

/** One triangle that covers the target. */
export const FULL_SCREEN = `
void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }
`;

/** Runs a program for every pixel of a rectangle of the bound framebuffer. */
export function fill(
  /** @type {WebGL2RenderingContext} */ gl,
  /** @type {number} */ width,
  /** @type {number} */ height,
) {
  gl.viewport(0, 0, width, height);
  gl.disable(gl.DEPTH_TEST);
  gl.disable(gl.CULL_FACE);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
}
