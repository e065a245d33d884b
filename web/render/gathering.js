// What many exact masks of one view say together. Each pixel of a 4x4 block looks at points of its own of a light, so that
// of views that are shifted by 0 to 3 pixels either way every pixel gets the counts of all 16: 256 points of a light that
// has 16 in each mask, and 128 segments of the ambient light. A reference, for pictures of what rests. No estimate: every
// count is one that the server traced for this very surface.
import { PARTS } from './shaders/accumulate.js';
import { OPEN_SEGMENTS } from '../wire/planes.js';

/**
 * @typedef {import('../wire/planes.js').Planes} Planes
 * @typedef {import('./masks.js').Masks} Masks
 * @typedef {{left: number, top: number}} Place of the picture's first pixel within masks
 * @typedef {{width: number, height: number, layers: number[], shares: Uint8Array}} Gathered shares in parts of PARTS, as
 *   large as the masks that they are shown with, a layer behind the other; layers: of each light its own, -1 where its
 *   bits are taken as they are; the last one is the ambient light's
 */

/** Of masks: bit of a plane at a pixel. @param {Masks} masks */
function bitsOf({ width, height, words }) {
  const tilesX = Math.ceil(width / 8),
    tilesY = Math.ceil(height / 8);
  return (/** @type {number} */ plane, /** @type {number} */ x, /** @type {number} */ y) => {
    const bit = (y & 7) * 8 + (x & 7);
    const word = words[2 * ((plane * tilesY + (y >> 3)) * tilesX + (x >> 3)) + (bit >> 5)];
    return (word >>> (bit & 31)) & 1;
  };
}

/** The side of the blocks whose pixels look at different points: protocol/WIRE.md, Soft shadows. */
export const BLOCK = 4;

export class Gathering {
  /**
   * @param {{width: number, height: number}} size of the picture
   * @param {Planes} planes of all masks
   * @param {number[]} layers of the lights, of layersOf()
   */
  constructor({ width, height }, planes, layers) {
    this.width = width;
    this.height = height;
    this.planes = planes;
    this.layers = layers;
    /** @type {{first: number, samples: number, sums: Uint16Array}[]} of each layer, the ambient light last */
    this.sums = [];
    layers.forEach((layer, light) => {
      if (layer >= 0) this.sums.push(this.nothing(planes.first[light], planes.samples[light]));
    });
    this.sums.push(this.nothing(planes.occlusion, OPEN_SEGMENTS));
    this.count = 0;
  }

  /** @private */
  nothing(/** @type {number} */ first, /** @type {number} */ samples) {
    return { first, samples, sums: new Uint16Array(this.width * this.height) };
  }

  /** Masks of the same view, in which the picture lies at another place. @param {Masks} masks @param {Place} place */
  add(masks, { left, top }) {
    const bit = bitsOf(masks);
    for (const { first, samples, sums } of this.sums) {
      if (first < 0) continue;
      let i = 0;
      for (let y = top; y < top + this.height; ++y)
        for (let x = left; x < left + this.width; ++x, ++i) {
          if (bit(first, x, y)) {
            sums[i] += samples;
            continue;
          }
          let number = 0;
          for (let more = samples, plane = first + 1; more > 1; more >>= 1, ++plane) number = 2 * number + bit(plane, x, y);
          sums[i] += number;
        }
    }
    ++this.count;
  }

  /** The means, to be shown with masks in which the picture lies there. @param {Masks} masks @param {Place} place */
  shares(masks, { left, top }) {
    const { width, height, layers } = this;
    const size = masks.width * masks.height;
    const shares = new Uint8Array(size * this.sums.length);
    this.sums.forEach(({ samples, sums }, layer) => {
      const whole = samples * this.count;
      for (let y = 0, i = 0; y < height; ++y)
        for (let x = 0; x < width; ++x, ++i)
          shares[layer * size + (y + top) * masks.width + x + left] = Math.round((sums[i] * PARTS) / whole);
    });
    return { width: masks.width, height: masks.height, layers, shares };
  }
}
