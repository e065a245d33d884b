// Vectors as arrays of three numbers, quaternions as (x, y, z, w).

/** @param {number[]} a @param {number[]} b */
export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
/** @param {number[]} a @param {number[]} b */
export const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
/** @param {number[]} a @param {number} s */
export const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
/** @param {number[]} a */
export const length = (a) => Math.hypot(a[0], a[1], a[2]);
/** @param {number[]} a @param {number[]} b */
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

/** @param {number[]} q */
export const conjugate = (q) => [-q[0], -q[1], -q[2], q[3]];

/** @param {number[]} p @param {number[]} q */
export function multiply(p, q) {
  const [px, py, pz, pw] = p;
  const [qx, qy, qz, qw] = q;
  return [
    pw * qx + px * qw + py * qz - pz * qy,
    pw * qy + py * qw + pz * qx - px * qz,
    pw * qz + pz * qw + px * qy - py * qx,
    pw * qw - px * qx - py * qy - pz * qz,
  ];
}

/** @param {number[]} q unit @param {number[]} v */
export function rotate(q, v) {
  const t = scale(cross(q, v), 2);
  return add(add(v, scale(t, q[3])), cross(q, t));
}

/** @param {number[]} q */
export function normalized(q) {
  const size = Math.hypot(...q);
  return q.map((part) => part / size);
}

/** @param {number} angle radians @param {number[]} axis unit */
export function aboutAxis(angle, axis) {
  const s = Math.sin(angle / 2);
  return [axis[0] * s, axis[1] * s, axis[2] * s, Math.cos(angle / 2)];
}
