// Which planes of a mask belong to which light, where lights are seen from several points: common/light_planes.h. A light
// without an extent has one plane; one of which k points are traced has 1 + log2(k): that of pixels that see them all,
// and the bits of the number seen, the most significant first. Behind them stand the planes of the ambient light's
// occlusion, if it is counted: of how many of 8 segments nothing near blocks.
//
// What is counted is one number, as common/sample_counts.h: the points of each light that has an extent, 1, 4 or 16, and
// beside that which pixels count occlusion.

/**
 * @typedef {{first: number[], samples: number[], occlusion: number, halved: boolean, total: number}} Planes for each
 *   light, its first plane and its points; then the first plane of the occlusion, -1 where that is not counted, and
 *   whether pixels of even column and row alone count it
 * @typedef {'none' | 'half' | 'full'} Occlusion which pixels count it: `half`, those of even column and row
 */

export const OCCLUSION = { none: 0, half: 64, full: 128 };
export const OPEN_SEGMENTS = 8;

const pointsIn = (/** @type {number} */ samples) => samples & 63;

/** @param {number} samples */
export const areSamples = (samples) => [1, 4, 16].includes(pointsIn(samples)) && samples < 192;

/** No more than both say. @param {number} a @param {number} b */
export const fewest = (a, b) => Math.min(pointsIn(a), pointsIn(b)) + Math.min(a - pointsIn(a), b - pointsIn(b));

/**
 * @param {boolean[]} areas which lights have an extent
 * @param {number} samples what is counted
 * @returns {Planes}
 */
export function planesOf(areas, samples) {
  let total = 0;
  const first = [];
  const points = areas.map((area) => (area ? pointsIn(samples) : 1));
  for (const each of points) {
    first.push(total);
    total += 1 + Math.log2(each);
  }
  if (samples < OCCLUSION.half) return { first, samples: points, occlusion: -1, halved: false, total };
  return { first, samples: points, occlusion: total, halved: samples < OCCLUSION.full, total: total + 4 };
}

/** @param {number} lights of which each has one bit a pixel */
export const hardPlanes = (lights) => planesOf(Array(lights).fill(false), 1);

/** Whether masks say more than one bit of each light. @param {Planes} planes */
export const countsPoints = ({ first, total }) => total > first.length;

/**
 * How many of the light's points a pixel sees. `lit` says of a plane whether the pixel's bit is set.
 * @param {Planes} planes @param {number} light @param {(plane: number) => number} lit @returns {number}
 */
export function seenOf({ first, samples }, light, lit) {
  const all = samples[light];
  let plane = first[light];
  if (lit(plane)) return all;
  let number = 0;
  for (let left = all; left > 1; left /= 2) number = 2 * number + lit(++plane);
  return number;
}
