// Which planes of a mask belong to which light, where lights are seen from several points: common/light_planes.h. A light
// without an extent has one plane; one of which k points are traced has 1 + log2(k): that of pixels that see them all,
// and the bits of the number seen, the most significant first.

/** @typedef {{first: number[], samples: number[], total: number}} Planes for each light, its first plane and its points */

/**
 * @param {boolean[]} areas which lights have an extent
 * @param {number} samples points of each of them: 1, 4 or 16
 * @returns {Planes}
 */
export function planesOf(areas, samples) {
  let total = 0;
  const first = [];
  const points = areas.map((area) => (area ? samples : 1));
  for (const each of points) {
    first.push(total);
    total += 1 + Math.log2(each);
  }
  return { first, samples: points, total };
}

/** @param {number} lights of which each has one bit a pixel */
export const hardPlanes = (lights) => planesOf(Array(lights).fill(false), 1);

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
