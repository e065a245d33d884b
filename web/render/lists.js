// Lists in textures: WebGL2 has no buffers that shaders may read anywhere.
import { RenderError, texture2d } from './gl.js';

const CHUNK = 1 << 16; // elements that are put together at a time

/** log2 of the width of the textures that hold lists. */
export function rowBits(/** @type {WebGL2RenderingContext} */ gl) {
  return Math.min(12, Math.floor(Math.log2(gl.getParameter(gl.MAX_TEXTURE_SIZE))));
}

/** A list of elements of four numbers each, row by row in a texture. */
export class List {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {'float' | 'uint'} kind
   * @param {number} count
   */
  constructor(gl, kind, count) {
    this.gl = gl;
    const bits = rowBits(gl);
    this.width = 1 << bits;
    const height = Math.max(1, Math.ceil(count / this.width));
    if (height > gl.getParameter(gl.MAX_TEXTURE_SIZE))
      throw new RenderError('This scene has more triangles than this device can draw.');
    const floats = kind === 'float';
    this.format = floats ? gl.RGBA : gl.RGBA_INTEGER;
    this.type = floats ? gl.FLOAT : gl.UNSIGNED_INT;
    const { target, texture } = texture2d(gl, floats ? gl.RGBA32F : gl.RGBA32UI, this.width, height);
    this.target = target;
    this.texture = texture;
  }

  /**
   * Replaces the elements from `first` on.
   * @param {number} first
   * @param {Float32Array | Uint32Array} data four numbers for each
   */
  put(first, data) {
    const { gl, width } = this;
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
    const end = first + data.length / 4;
    for (let at = first; at < end;) {
      const x = at % width;
      const whole = x === 0 && end - at >= width;
      const columns = whole ? width : Math.min(width - x, end - at);
      const rows = whole ? Math.floor((end - at) / width) : 1;
      gl.texSubImage2D(
        gl.TEXTURE_2D,
        0,
        x,
        Math.floor(at / width),
        columns,
        rows,
        this.format,
        this.type,
        data,
        4 * (at - first),
      );
      at += columns * rows;
    }
  }

  /**
   * Fills the list from `first` to `end` by pieces, so that no second copy of a large scene is ever there.
   * @param {number} first
   * @param {number} end
   * @param {(element: number, into: any, at: number) => void} write
   */
  fill(first, end, write) {
    const Kind = this.type === this.gl.FLOAT ? Float32Array : Uint32Array;
    for (let from = first; from < end; from += CHUNK) {
      const piece = new Kind(4 * Math.min(CHUNK, end - from));
      for (let i = 0; 4 * i < piece.length; ++i) write(from + i, piece, 4 * i);
      this.put(from, piece);
    }
  }
}
