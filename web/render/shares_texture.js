// Gathered shares on the device.
import { textureArray } from './gl.js';

/** @typedef {import('./gathering.js').Gathered} Gathered */

export class SharesTexture {
  constructor(/** @type {WebGL2RenderingContext} */ gl) {
    this.gl = gl;
    /** @type {(import('./gl.js').Texture & {layers: number}) | null} */
    this.texture = null;
    /** @type {Gathered | null} what the texture holds */
    this.held = null;
  }

  /** @param {Gathered} gathered */
  put(gathered) {
    if (this.texture && this.held === gathered) return this.texture;
    this.dispose();
    const { gl } = this;
    const { width, height, shares } = gathered;
    const layers = shares.length / (width * height);
    this.texture = textureArray(gl, gl.R8UI, width, height, layers);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    const [format, type] = [gl.RED_INTEGER, gl.UNSIGNED_BYTE];
    gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, 0, 0, 0, width, height, layers, format, type, shares);
    this.held = gathered;
    return this.texture;
  }

  dispose() {
    if (this.texture) this.gl.deleteTexture(this.texture.texture);
    this.texture = this.held = null;
  }
}
