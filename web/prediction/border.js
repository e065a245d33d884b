// The prediction border (dissertation 3.4): pixels traced around the picture that is shown, so that there are masks for
// what the camera turns to. As client/prediction/border.h of the native client.
import { rounded } from '../wire/camera.js';
import { add, aboutAxis, conjugate, multiply, normalized, rotate, scale, subtract } from './vector.js';

/**
 * @typedef {{width: number, height: number, borderX: number, borderY: number}} ViewSize the picture, and the pixels
 *   around it: left and right together, top and bottom together
 * @typedef {{left: number, top: number}} BorderPlace pixels of the border left of the picture and above it
 * @typedef {{position: number[], orientation: number[], verticalFov: number}} Pose radians
 */

/** @param {ViewSize} size */
export const tracedWidth = (size) => size.width + size.borderX;
/** @param {ViewSize} size */
export const tracedHeight = (size) => size.height + size.borderY;

/** @param {ViewSize} size @returns {BorderPlace} */
export const centred = (size) => ({ left: Math.floor(size.borderX / 2), top: Math.floor(size.borderY / 2) });

/** @param {number} border @param {number} shift pixels by which what is wanted lies to the right, or below */
const before = (border, shift) => Math.min(Math.max(Math.round(border / 2 - shift), 0), border);

/**
 * The best place of the border if the camera, now at `now`, is at `then` when the masks are used. Only the turn counts.
 * @param {ViewSize} size @param {Pose} now @param {Pose} then @returns {BorderPlace}
 */
export function towards(size, now, then) {
  const forward = rotate(conjugate(now.orientation), rotate(then.orientation, [0, 0, -1]));
  if (forward[2] > -0.1) return centred(size); // it turns away completely: no border helps
  const perTangent = size.height / (2 * Math.tan(now.verticalFov / 2));
  return {
    left: before(size.borderX, (perTangent * forward[0]) / -forward[2]),
    top: before(size.borderY, (perTangent * forward[1]) / forward[2]),
  };
}

/**
 * The pose after `now` if the camera continues as from `earlier` to `now`, for `steps` times as long.
 * @param {Pose} earlier @param {Pose} now @param {number} steps @returns {Pose}
 */
export function extrapolate(earlier, now, steps) {
  let turn = multiply(now.orientation, conjugate(earlier.orientation));
  if (turn[3] < 0) turn = turn.map((part) => -part);
  const size = Math.hypot(turn[0], turn[1], turn[2]);
  const angle = 2 * Math.atan2(size, turn[3]); // the cosine alone says little of a small angle
  const orientation =
    angle > 1e-6
      ? multiply(aboutAxis(steps * angle, [turn[0] / size, turn[1] / size, turn[2] / size]), now.orientation)
      : now.orientation;
  return { ...now, position: add(now.position, scale(subtract(now.position, earlier.position), steps)), orientation };
}

const NEAR = 0.05; // metres

/**
 * The camera of the traced buffer, whose frustum includes the border.
 * @param {Pose} pose @param {ViewSize} size @param {BorderPlace} place @returns {import('../wire/camera.js').Camera}
 */
export function viewOf(pose, size, place) {
  const up = Math.tan(pose.verticalFov / 2);
  const right = (up * size.width) / size.height;
  const [across, down] = [(2 * right) / size.width, (2 * up) / size.height]; // tangent per pixel
  return rounded({
    position: pose.position,
    orientation: normalized(pose.orientation),
    near: NEAR,
    tanLeft: right + across * place.left,
    tanRight: right + across * (size.borderX - place.left),
    tanUp: up + down * place.top,
    tanDown: up + down * (size.borderY - place.top),
  });
}

/**
 * Where the border of such a camera lies.
 * @param {import('../wire/camera.js').Camera} traced @param {ViewSize} size @returns {BorderPlace}
 */
export function placeOf(traced, size) {
  const width = (traced.tanLeft + traced.tanRight) / tracedWidth(size);
  const height = (traced.tanUp + traced.tanDown) / tracedHeight(size);
  return {
    left: before(size.borderX, (traced.tanRight - traced.tanLeft) / width / 2),
    top: before(size.borderY, (traced.tanDown - traced.tanUp) / height / 2),
  };
}

/**
 * The camera of the shown picture alone.
 * @param {import('../wire/camera.js').Camera} traced @param {ViewSize} size
 */
export function shownPart(traced, size) {
  const width = (traced.tanLeft + traced.tanRight) / tracedWidth(size);
  const height = (traced.tanUp + traced.tanDown) / tracedHeight(size);
  const place = placeOf(traced, size);
  return rounded({
    ...traced,
    tanLeft: traced.tanLeft - width * place.left,
    tanRight: traced.tanRight - width * (size.borderX - place.left),
    tanUp: traced.tanUp - height * place.top,
    tanDown: traced.tanDown - height * (size.borderY - place.top),
  });
}
