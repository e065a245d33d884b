// The vertices and triangles of moving instances at a scene time, in binary32 operation by operation, so that they are
// the floats that the server traces.
import { isNormal } from './matrices.js';

const f = Math.fround;

/**
 * @typedef {{position: (vertex: number, x: number, y: number, z: number) => void,
 *   normal: (vertex: number, x: number, y: number, z: number) => void,
 *   triangle: (triangle: number, a: number, b: number, c: number) => void}} Posed takes what has moved
 */

/**
 * Brings one instance to its place.
 * @param {import('./pack.js').ScenePack} pack
 * @param {{node: number, first_vertex: number, vertices: number, first_triangle: number, triangles: number,
 *   flat: boolean}} instance
 * @param {Float64Array} nodeToWorld
 * @param {Posed} into
 */
export function poseInstance(pack, instance, nodeToWorld, into) {
  const m = Float32Array.from(nodeToWorld);
  const mirrored = determinant(m) < 0;
  const world = placeVertices(pack, instance, m);
  for (let v = 0; v < instance.vertices; ++v)
    into.position(instance.first_vertex + v, world[3 * v], world[3 * v + 1], world[3 * v + 2]);
  if (!instance.flat) turnNormals(pack, instance, m, mirrored, into);
  for (let t = instance.first_triangle; t < instance.first_triangle + instance.triangles; ++t) {
    const a = pack.triangles[3 * t];
    const b = pack.triangles[3 * t + (mirrored ? 2 : 1)],
      c = pack.triangles[3 * t + (mirrored ? 1 : 2)];
    into.triangle(t, a, b, c);
    if (instance.flat) faceNormal(world, [a, b, c], instance.first_vertex, into);
  }
}

function determinant(/** @type {Float32Array} */ m) {
  const minor = (/** @type {number} */ a, /** @type {number} */ b, /** @type {number} */ c, /** @type {number} */ d) =>
    f(f(m[a] * m[b]) - f(m[c] * m[d]));
  return f(f(f(m[0] * minor(5, 10, 9, 6)) - f(m[4] * minor(1, 10, 9, 2))) + f(m[8] * minor(1, 6, 5, 2)));
}

function placeVertices(
  /** @type {import('./pack.js').ScenePack} */ pack,
  /** @type {{first_vertex: number, vertices: number}} */ instance,
  /** @type {Float32Array} */ m,
) {
  const world = new Float32Array(3 * instance.vertices);
  for (let v = 0; v < instance.vertices; ++v) {
    const at = 3 * (instance.first_vertex + v);
    const x = pack.positions[at],
      y = pack.positions[at + 1],
      z = pack.positions[at + 2];
    for (let r = 0; r < 3; ++r) world[3 * v + r] = f(f(f(m[r] * x) + f(m[4 + r] * y)) + f(f(m[8 + r] * z) + m[12 + r]));
  }
  return world;
}

/** By the cofactor matrix, which is the inverse transpose without its division. */
function turnNormals(
  /** @type {import('./pack.js').ScenePack} */ pack,
  /** @type {{first_vertex: number, vertices: number}} */ instance,
  /** @type {Float32Array} */ m,
  /** @type {boolean} */ mirrored,
  /** @type {Posed} */ into,
) {
  const column = (/** @type {number} */ c) => [m[4 * c], m[4 * c + 1], m[4 * c + 2]];
  const sign = mirrored ? -1 : 1;
  const cofactors = [cross(column(1), column(2)), cross(column(2), column(0)), cross(column(0), column(1))];
  for (let v = instance.first_vertex; v < instance.first_vertex + instance.vertices; ++v) {
    const x = pack.normals[3 * v],
      y = pack.normals[3 * v + 1],
      z = pack.normals[3 * v + 2];
    const turned = [0, 1, 2].map((r) =>
      f(f(f(sign * cofactors[0][r] * x) + f(sign * cofactors[1][r] * y)) + f(sign * cofactors[2][r] * z)),
    );
    const [nx, ny, nz] = unitOrUp(turned);
    into.normal(v, nx, ny, nz);
  }
}

function faceNormal(
  /** @type {Float32Array} */ world,
  /** @type {number[]} */ corners,
  /** @type {number} */ firstVertex,
  /** @type {Posed} */ into,
) {
  const at = (/** @type {number} */ v) => Array.from(world.subarray(3 * (v - firstVertex), 3 * (v - firstVertex) + 3));
  const [p0, p1, p2] = corners.map(at);
  const [nx, ny, nz] = unitOrUp(
    cross(
      p1.map((p, i) => f(p - p0[i])),
      p2.map((p, i) => f(p - p0[i])),
    ),
  );
  for (const vertex of corners) into.normal(vertex, nx, ny, nz);
}

function cross(/** @type {number[]} */ a, /** @type {number[]} */ b) {
  return [f(f(a[1] * b[2]) - f(a[2] * b[1])), f(f(a[2] * b[0]) - f(a[0] * b[2])), f(f(a[0] * b[1]) - f(a[1] * b[0]))];
}

function unitOrUp(/** @type {number[]} */ v) {
  const length = f(Math.sqrt(f(f(f(v[0] * v[0]) + f(v[1] * v[1])) + f(v[2] * v[2]))));
  return isNormal(length) ? v.map((value) => f(value / length)) : [0, 1, 0];
}
