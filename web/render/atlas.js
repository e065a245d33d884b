// Where each level of each texture lies in one texture with layers. Rectangles stand in rows, the highest first.
import { RenderError, textureArray } from './gl.js';

const LEAST_SIDE = 256;

/** @typedef {{number: number, layer: number, x: number, y: number, width: number, height: number}} Level */

export class Atlas {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {{width: number, height: number}[]} textures
   */
  constructor(gl, textures) {
    let number = 0;
    /** @type {Level[][]} of each texture, the largest first */
    this.levels = textures.map((texture) =>
      levelsOf(texture).map((size) => ({ number: number++, layer: 0, x: 0, y: 0, ...size })),
    );
    const all = this.levels.flat();
    const longest = all.reduce((side, level) => Math.max(side, level.width, level.height), LEAST_SIDE);
    const side = 2 ** Math.ceil(Math.log2(longest));
    if (side > gl.getParameter(gl.MAX_TEXTURE_SIZE))
      throw new RenderError(`This scene has textures of ${longest} texels a side, more than this device can hold.`);
    const layers = place(all, side);
    if (layers > gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS))
      throw new RenderError('This scene has more textures than this device can hold.');
    this.texture = textureArray(gl, gl.RGBA8, textures.length ? side : 1, textures.length ? side : 1, layers);
  }
}

/** Each half the size of the one before, rounded down. */
function levelsOf(/** @type {{width: number, height: number}} */ { width, height }) {
  const levels = [{ width, height }];
  while (width > 1 || height > 1) {
    ((width = Math.max(width >> 1, 1)), (height = Math.max(height >> 1, 1)));
    levels.push({ width, height });
  }
  return levels;
}

/** Returns how many layers of `side` x `side` are needed. */
function place(/** @type {Level[]} */ levels, /** @type {number} */ side) {
  const sorted = [...levels].sort((a, b) => b.height - a.height || b.width - a.width);
  let layer = 0,
    x = 0,
    y = 0,
    rowHeight = 0;
  for (const level of sorted) {
    if (x + level.width > side) ((x = 0), (y += rowHeight), (rowHeight = 0));
    if (y + level.height > side) ((x = y = rowHeight = 0), ++layer);
    Object.assign(level, { layer, x, y });
    x += level.width;
    rowHeight = Math.max(rowHeight, level.height);
  }
  return layer + 1;
}
