// Transforms of nodes in binary64, column by column as GLM has them, with the operations in GLM's order: what is rounded
// to binary32 in the end is then what the server has.

const f = Math.fround;

/** @typedef {Float64Array} Matrix 16 numbers, column by column */

/** @returns {Matrix} */
export function product(/** @type {ArrayLike<number>} */ a, /** @type {ArrayLike<number>} */ b) {
  const out = new Float64Array(16);
  for (let c = 0; c < 4; ++c)
    for (let r = 0; r < 4; ++r)
      out[4 * c + r] = a[r] * b[4 * c] + a[4 + r] * b[4 * c + 1] + a[8 + r] * b[4 * c + 2] + a[12 + r] * b[4 * c + 3];
  return out;
}

/**
 * The transform from node to parent. A rotation that cannot be normalised counts as none.
 * @param {{matrix?: number[], translation: ArrayLike<number>, rotation: ArrayLike<number>, scale: ArrayLike<number>}}
 *   node of binary32 numbers
 * @returns {Matrix}
 */
export function localTransform(node) {
  if (node.matrix) return Float64Array.from(node.matrix);
  const [tx, ty, tz] = [node.translation[0], node.translation[1], node.translation[2]];
  const [x, y, z, w] = unitRotation(node.rotation);
  const axes = [
    [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
    [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
    [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
  ];
  const out = new Float64Array(16);
  for (let c = 0; c < 3; ++c) for (let r = 0; r < 3; ++r) out[4 * c + r] = axes[c][r] * node.scale[c];
  out.set([tx, ty, tz, 1], 12);
  return out;
}

/** Divides in binary32, as the node's rotation is. */
function unitRotation(/** @type {ArrayLike<number>} */ q) {
  const squares = [f(q[0] * q[0]), f(q[1] * q[1]), f(q[2] * q[2]), f(q[3] * q[3])];
  const length = f(Math.sqrt(f(f(squares[3] + squares[0]) + f(squares[1] + squares[2]))));
  if (!isNormal(length)) return [0, 0, 0, 1];
  return [f(q[0] / length), f(q[1] / length), f(q[2] / length), f(q[3] / length)];
}

/** Whether a binary32 number can be divided by: neither 0, nor subnormal, nor infinite, nor none. */
export function isNormal(/** @type {number} */ value) {
  const size = Math.abs(value);
  return size >= 1.1754943508222875e-38 && size < Infinity;
}
