// A camera as shaders take it: gpu::set_view, in binary32 operation by operation, so that client and server cast the
// same rays.

const f = Math.fround;

/**
 * @typedef {{position: ArrayLike<number>, orientation: ArrayLike<number>, tanLeft: number, tanRight: number,
 *   tanUp: number, tanDown: number, near: number}} Camera
 * @typedef {{camera: number[], forward: number[], ray_corner: number[], ray_dx: number[], ray_dy: number[],
 *   camera_to_clip: Float32Array, near_plane: number, width: number, height: number}} View
 */

const scaled = (/** @type {number[]} */ v, /** @type {number} */ by) => v.map((value) => f(value * by));
const sum = (/** @type {number[]} */ a, /** @type {number[]} */ b) => a.map((value, i) => f(value + b[i]));
const dot = (/** @type {number[]} */ a, /** @type {number[]} */ b) =>
  f(f(f(a[0] * b[0]) + f(a[1] * b[1])) + f(a[2] * b[2]));

/** glm::mat3_cast: the camera's right, up and back in the world. */
function axesOf(/** @type {ArrayLike<number>} */ orientation) {
  const [x, y, z, w] = Array.from(orientation, f);
  const twice = (/** @type {number} */ a) => f(2 * a);
  const xx = f(x * x),
    yy = f(y * y),
    zz = f(z * z),
    xz = f(x * z),
    xy = f(x * y),
    yz = f(y * z);
  const wx = f(w * x),
    wy = f(w * y),
    wz = f(w * z);
  return [
    [f(1 - twice(f(yy + zz))), twice(f(xy + wz)), twice(f(xz - wy))],
    [twice(f(xy - wz)), f(1 - twice(f(xx + zz))), twice(f(yz + wx))],
    [twice(f(xz + wy)), twice(f(yz - wx)), f(1 - twice(f(xx + yy)))],
  ];
}

/**
 * The view of a picture, rows from the top. Depth is reversed (z = near / depth) if the context can have it so, else as
 * OpenGL's, which needs the whole range from -w to w.
 * @param {Camera} camera
 * @param {number} width
 * @param {number} height
 * @param {boolean} reversedDepth
 * @returns {View}
 */
export function viewOf(camera, width, height, reversedDepth) {
  const [right, up, back] = axesOf(camera.orientation);
  const forward = back.map((value) => -value);
  const [tanLeft, tanRight, tanUp, tanDown, near] = [
    camera.tanLeft,
    camera.tanRight,
    camera.tanUp,
    camera.tanDown,
    camera.near,
  ].map(f);
  const across = f(tanLeft + tanRight),
    upright = f(tanUp + tanDown);
  const by = (/** @type {number[]} */ v, /** @type {number} */ divisor) => v.map((value) => f(value / divisor));
  const x = by(sum(scaled(right, 2), scaled(forward, -f(tanRight - tanLeft))), across);
  const y = by(sum(scaled(up, -2), scaled(forward, f(tanUp - tanDown))), upright);
  const z = reversedDepth ? [0, 0, 0, near] : [...forward, f(-2 * near)];
  const rows = [[...x, 0], [...y, 0], z, [...forward, 0]];
  const matrix = new Float32Array(16);
  for (let c = 0; c < 4; ++c) for (let r = 0; r < 4; ++r) matrix[4 * c + r] = rows[r][c];
  return {
    camera: Array.from(camera.position, f),
    forward,
    ray_corner: sum(sum(forward, scaled(right, -tanLeft)), scaled(up, tanUp)),
    ray_dx: scaled(right, f(across / width)),
    ray_dy: scaled(up, f(-upright / height)),
    camera_to_clip: matrix,
    near_plane: near,
    width,
    height,
  };
}

/** gpu::SeenView: a view that was rasterised before, as the uniforms of shaders/predict.js. */
export function seenUniforms(/** @type {View} */ view) {
  const inverse = (/** @type {number[]} */ v) => v.map((value) => f(value / dot(v, v)));
  return {
    seen_eye: view.camera,
    seen_forward: view.forward,
    seen_ray_corner: view.ray_corner,
    seen_ray_dx: view.ray_dx,
    seen_ray_dy: view.ray_dy,
    seen_across: inverse(view.ray_dx),
    seen_down: inverse(view.ray_dy),
    seen_pixel: f(Math.sqrt(dot(view.ray_dx, view.ray_dx))),
    seen_size: [view.width, view.height],
  };
}

/** @returns {boolean} */
export function sameEye(/** @type {Camera} */ a, /** @type {Camera} */ b) {
  return (
    [0, 1, 2].every((i) => a.position[i] === b.position[i]) &&
    [0, 1, 2, 3].every((i) => a.orientation[i] === b.orientation[i])
  );
}

/**
 * Where the picture of `shown` lies within that of `traced`, which may have a border around it: its first pixel there.
 * null if the two do not share their pixels.
 * @param {Camera} shown
 * @param {{width: number, height: number}} size of what is shown
 * @param {Camera} traced
 * @param {{width: number, height: number}} tracedSize
 */
export function placeWithin(shown, size, traced, tracedSize) {
  if (!sameEye(shown, traced) || shown.near !== traced.near) return null;
  const place = (
    /** @type {number} */ low,
    /** @type {number} */ high,
    /** @type {number} */ tracedLow,
    /** @type {number} */ tracedHigh,
    /** @type {number} */ pixels,
    /** @type {number} */ tracedPixels,
  ) => {
    const pixel = (tracedLow + tracedHigh) / tracedPixels;
    const first = Math.round((tracedLow - low) / pixel);
    const exact = Math.abs((tracedLow - low) / pixel - first) < 1e-2 && Math.abs((low + high) / pixel - pixels) < 1e-2;
    return exact && first >= 0 && first + pixels <= tracedPixels ? first : -1;
  };
  const left = place(shown.tanLeft, shown.tanRight, traced.tanLeft, traced.tanRight, size.width, tracedSize.width);
  const top = place(shown.tanUp, shown.tanDown, traced.tanUp, traced.tanDown, size.height, tracedSize.height);
  return left >= 0 && top >= 0 ? [left, top] : null;
}
