// Masks on the device: a texel of two words for each tile, a layer for each plane, as the words lie in memory.
import { textureArray } from './gl.js';

/**
 * @typedef {{camera: import('./view.js').Camera, width: number, height: number, words: Uint32Array,
 *   sceneTimeUs: number, planes?: import('../wire/planes.js').Planes, lightsVersion?: number, session?: number}} Masks the
 *   newest whole frame; two words per tile and plane, the low one first. Without `planes` each light has one. The last two
 *   say which masks may be averaged.
 */

export class MaskTexture {
  constructor(/** @type {WebGL2RenderingContext} */ gl) {
    this.gl = gl;
    /** @type {import('./gl.js').Texture & {layers: number}} before there are any, of a size like that of masks */
    this.texture = textureArray(gl, gl.RG32UI, 3, 3, 1);
    /** @type {Uint32Array} what the texture holds */
    this.held = new Uint32Array(0);
  }

  /** Uploads the rows of tiles that have changed. Returns how many of them. */
  put(/** @type {Masks} */ masks) {
    const { gl } = this;
    if (this.held === masks.words) return 0;
    const tilesX = Math.ceil(masks.width / 8),
      tilesY = Math.ceil(masks.height / 8);
    const planes = masks.words.length / (2 * tilesX * tilesY);
    const { texture } = this;
    const fits = texture.width === tilesX && texture.height === tilesY && texture.layers === planes;
    if (!fits) {
      gl.deleteTexture(texture.texture);
      this.texture = textureArray(gl, gl.RG32UI, tilesX, tilesY, Math.max(1, planes));
      this.held = new Uint32Array(0);
    }
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.texture.texture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
    const row = 2 * tilesX;
    let sent = 0;
    for (let plane = 0; plane < planes; ++plane) {
      for (let y = 0; y < tilesY;) {
        const first = y;
        while (y < tilesY && this.differs(masks.words, (plane * tilesY + y) * row, row)) ++y;
        if (y > first)
          gl.texSubImage3D(
            gl.TEXTURE_2D_ARRAY,
            0,
            0,
            first,
            plane,
            tilesX,
            y - first,
            1,
            gl.RG_INTEGER,
            gl.UNSIGNED_INT,
            masks.words,
            (plane * tilesY + first) * row,
          );
        sent += y - first;
        ++y;
      }
    }
    this.held = masks.words;
    return sent;
  }

  dispose() {
    this.gl.deleteTexture(this.texture.texture);
  }

  /** @private */
  differs(/** @type {Uint32Array} */ words, /** @type {number} */ from, /** @type {number} */ count) {
    if (this.held.length !== words.length) return true;
    for (let i = from; i < from + count; ++i) if (this.held[i] !== words[i]) return true;
    return false;
  }
}
