// Makes the levels of textures: gpu/scene/texels.cpp. Alpha is as the file has it, each colour the square root of its
// linear value, which the shader undoes by one multiplication; each level has the means of four texels in linear light.
import { fill, framebuffer, texture2d } from './gl.js';
import { Programs } from './programs.js';

/** A texture with room for a level, but no power of two a side where the device can: drivers compile anew for such ones. */
function roomFor(
  /** @type {WebGL2RenderingContext} */ gl,
  /** @type {number} */ format,
  /** @type {{width: number, height: number}} */ { width, height },
) {
  const most = gl.getParameter(gl.MAX_TEXTURE_SIZE);
  return texture2d(gl, format, Math.min(width | 3, most), Math.min(height | 3, most));
}

function linearOfSrgb(/** @type {number} */ byte) {
  const srgb = byte / 255;
  return srgb <= 0.04045 ? srgb / 12.92 : ((srgb + 0.055) / 1.055) ** 2.4;
}

export class TexelMaker {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {import('./atlas.js').Atlas} atlas
   */
  constructor(gl, atlas) {
    this.gl = gl;
    this.atlas = atlas;
    this.program = Programs.of(gl).level();
    this.table = texture2d(gl, gl.R32F, 256, 1);
    gl.texSubImage2D(
      gl.TEXTURE_2D,
      0,
      0,
      0,
      256,
      1,
      gl.RED,
      gl.FLOAT,
      Float32Array.from({ length: 256 }, (_, byte) => linearOfSrgb(byte)),
    );
    // Levels in between are kept in linear light where the device can draw into such textures.
    this.floats = gl.getExtension('EXT_color_buffer_float') !== null;
    this.target = /** @type {WebGLFramebuffer} */ (gl.createFramebuffer());
  }

  /**
   * @param {ImageBitmap | ImageData} image
   * @param {{width: number, height: number}} size as the scene states it
   * @param {import('./atlas.js').Level[]} levels
   */
  make(image, size, levels) {
    const { gl } = this;
    let from = this.upload(image, size);
    let coded = 0;
    this.draw(from, coded, levels[0]);
    levels.slice(1).forEach((level, i) => {
      const half = roomFor(gl, this.floats ? gl.RGBA32F : gl.RGBA8, level);
      const buffer = framebuffer(gl, half, null);
      const from_size = [levels[i].width, levels[i].height];
      this.run({ from, from_size, coded, halved: true, to_roots: !this.floats, place: [0, 0] });
      fill(gl, level.width, level.height);
      gl.deleteFramebuffer(buffer);
      gl.deleteTexture(from.texture);
      from = half;
      coded = this.floats ? 1 : 2;
      this.draw(from, coded, level);
    });
    gl.deleteTexture(from.texture);
  }

  /** The image's own bytes; one that is not of the size that the scene states is brought to it. */
  upload(/** @type {ImageBitmap | ImageData} */ image, /** @type {{width: number, height: number}} */ size) {
    const { gl } = this;
    const texture = roomFor(gl, gl.RGBA8, size);
    gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    const [w, h] = [Math.min(size.width, image.width), Math.min(size.height, image.height)];
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, image);
    return texture;
  }

  /** Copies a level into the atlas. */
  draw(
    /** @type {import('./gl.js').Texture} */ from,
    /** @type {number} */ coded,
    /** @type {import('./atlas.js').Level} */ level,
  ) {
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target);
    gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, this.atlas.texture.texture, 0, level.layer);
    const from_size = [level.width, level.height];
    this.run({ from, from_size, coded, halved: false, to_roots: true, place: [level.x, level.y] });
    gl.viewport(level.x, level.y, level.width, level.height);
    gl.disable(gl.DEPTH_TEST);
    gl.disable(gl.CULL_FACE);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /** @private */
  run(/** @type {Record<string, any>} */ values) {
    this.program.use({ linear_of_srgb: this.table, ...values });
  }

  dispose() {
    this.gl.deleteTexture(this.table.texture);
    this.gl.deleteFramebuffer(this.target);
  }
}
