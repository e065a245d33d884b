// A camera as the wire has it: a pose and the tangents of four half-angles. All numbers are rounded to binary32 where a
// camera is made, so that what is drawn is what was traced.
import { Malformed } from './bytes.js';

/**
 * @typedef {object} Camera
 * @property {number[]} position metres
 * @property {number[]} orientation unit quaternion (x, y, z, w), camera to world
 * @property {number} tanLeft
 * @property {number} tanRight
 * @property {number} tanUp
 * @property {number} tanDown
 * @property {number} near metres
 */

/** @param {Camera} camera @returns {Camera} */
export function rounded(camera) {
  const f = Math.fround;
  return {
    position: camera.position.map(f),
    orientation: camera.orientation.map(f),
    tanLeft: f(camera.tanLeft),
    tanRight: f(camera.tanRight),
    tanUp: f(camera.tanUp),
    tanDown: f(camera.tanDown),
    near: f(camera.near),
  };
}

/** Whether the two cameras see the very same. @param {Camera} a @param {Camera} b */
export function equal(a, b) {
  return (
    a.tanLeft === b.tanLeft &&
    a.tanRight === b.tanRight &&
    a.tanUp === b.tanUp &&
    a.tanDown === b.tanDown &&
    a.near === b.near &&
    a.position.every((value, i) => value === b.position[i]) &&
    a.orientation.every((value, i) => value === b.orientation[i])
  );
}

/** @param {import('./bytes.js').Writer} out @param {Camera} camera */
export function writeCamera(out, camera) {
  out.floats(camera.position);
  out.floats(camera.orientation);
  out.floats([camera.tanLeft, camera.tanRight, camera.tanUp, camera.tanDown, camera.near]);
}

/** @param {import('./bytes.js').Reader} from @returns {Camera} */
export function readCamera(from) {
  const [position, orientation] = [from.floats(3), from.floats(4)];
  const [tanLeft, tanRight, tanUp, tanDown, near] = from.floats(5);
  if (Math.abs(Math.hypot(...orientation) - 1) > 0.001) throw new Malformed('an orientation is not of length 1');
  if (!(tanLeft + tanRight > 0 && tanUp + tanDown > 0 && near > 0)) throw new Malformed('a frustum is empty');
  return { position, orientation, tanLeft, tanRight, tanUp, tanDown, near };
}
