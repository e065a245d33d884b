// Which triangles may be in view: runs of neighbouring ones are left out together where the box around them is not. What
// is drawn keeps its order, and its pixels: a run that is drawn needlessly changes nothing.

const LENGTH = 512; // triangles of a chunk
const SLACK = 1e-4; // of the numbers that are added, for their rounding

/** @typedef {{first: number, count: number}} Run of triangles */

export class Chunks {
  /** @param {import('../pack/pack.js').ScenePack} pack */
  constructor(pack) {
    this.resting = pack.info.resting.triangles;
    /** @type {Map<number, {boxes: Float32Array, group: import('../pack/pack.js').Group}>} by the group's first triangle */
    this.groups = new Map();
    for (const group of pack.info.groups)
      if (group.first_triangle < this.resting)
        this.groups.set(group.first_triangle, { group, boxes: boxesOf(pack, group) });
  }

  /**
   * @param {import('../pack/pack.js').Group} group what moves is always drawn
   * @param {number[]} camera
   * @param {Float32Array} toClip of points relative to the camera, column by column
   * @returns {Run[]}
   */
  inView(group, camera, toClip) {
    const known = this.groups.get(group.first_triangle);
    if (!known) return [{ first: group.first_triangle, count: group.triangles }];
    const planes = planesOf(toClip, camera);
    const end = group.first_triangle + group.triangles;
    /** @type {Run[]} */
    const runs = [];
    for (let chunk = 0; 6 * chunk < known.boxes.length; ++chunk) {
      if (!planes.every((plane) => reaches(known.boxes, 6 * chunk, plane))) continue;
      const first = group.first_triangle + LENGTH * chunk;
      const count = Math.min(LENGTH, end - first);
      const last = runs.at(-1);
      if (last && last.first + last.count === first) last.count += count;
      else runs.push({ first, count });
    }
    return runs;
  }
}

/** Least and greatest coordinates of each chunk of a group. */
function boxesOf(
  /** @type {import('../pack/pack.js').ScenePack} */ { positions, triangles },
  /** @type {import('../pack/pack.js').Group} */ group,
) {
  const boxes = new Float32Array(6 * Math.ceil(group.triangles / LENGTH));
  for (let at = 0; at < boxes.length; at += 6) boxes.fill(Infinity, at, at + 3).fill(-Infinity, at + 3, at + 6);
  for (let corner = 0; corner < 3 * group.triangles; ++corner) {
    const at = 6 * Math.floor(corner / (3 * LENGTH));
    const vertex = 3 * triangles[3 * group.first_triangle + corner];
    for (let c = 0; c < 3; ++c) {
      const value = positions[vertex + c];
      if (value < boxes[at + c]) boxes[at + c] = value;
      if (value > boxes[at + 3 + c]) boxes[at + 3 + c] = value;
    }
  }
  return boxes;
}

/** The four sides of the frustum and the plane of the eye, in the world: nothing shows where one of them is negative. */
function planesOf(/** @type {Float32Array} */ m, /** @type {number[]} */ camera) {
  const row = (/** @type {number} */ r) => [m[r], m[4 + r], m[8 + r], m[12 + r]];
  const [x, y, w] = [row(0), row(1), row(3)];
  const sides = [x, y].flatMap((side) => [w.map((value, i) => value + side[i]), w.map((value, i) => value - side[i])]);
  return [...sides, w].map(([a, b, c, d]) => [a, b, c, d - a * camera[0] - b * camera[1] - c * camera[2]]);
}

/** Whether a box reaches the positive side of a plane. */
function reaches(/** @type {Float32Array} */ boxes, /** @type {number} */ at, /** @type {number[]} */ plane) {
  let sum = plane[3],
    size = Math.abs(plane[3]);
  for (let c = 0; c < 3; ++c) {
    const term = plane[c] * boxes[at + (plane[c] > 0 ? 3 : 0) + c];
    sum += term;
    size += Math.abs(term);
  }
  return sum >= -SLACK * size;
}
