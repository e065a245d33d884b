// How a change of the camera moves the picture: the figures from which the error of a prediction is estimated. As
// client/prediction/motion.h of the native client.
import { shownPart } from './border.js';
import { add, conjugate, length, rotate, scale, subtract } from './vector.js';

const POINTS_ACROSS = 12,
  POINTS_DOWN = 7; // sample points, evenly over the picture

/**
 * @typedef {object} ImageMotion
 * @property {number} unseen share of the later picture that lies outside the buffer traced for the earlier camera
 * @property {number} turn mean distance that turning moves the picture's points, in picture widths
 * @property {number} shift the same by translation, for points at the given distance
 */

/** Where a camera sees a direction, as tangents; null if it does not. @param {number[]} fromWorld @param {number[]} way */
function placeOf(fromWorld, way) {
  const d = rotate(fromWorld, way);
  return d[2] > -1e-3 * length(d) ? null : [d[0] / -d[2], d[1] / -d[2]];
}

/**
 * @param {import('../wire/camera.js').Camera} traced border included
 * @param {import('../wire/camera.js').Camera} later of which the shown part counts
 * @param {import('./border.js').ViewSize} size
 * @param {number} distance metres, approximate, of what is seen
 * @returns {ImageMotion}
 */
export function motionBetween(traced, later, size, distance) {
  const shown = shownPart(later, size);
  const fromWorld = conjugate(traced.orientation);
  const [width, height] = [shown.tanLeft + shown.tanRight, shown.tanUp + shown.tanDown];
  const sum = { unseen: 0, turn: 0, shift: 0 };
  for (let j = 0; j < POINTS_DOWN; ++j) {
    for (let i = 0; i < POINTS_ACROSS; ++i) {
      const ray = [
        -shown.tanLeft + (width * (i + 0.5)) / POINTS_ACROSS,
        shown.tanUp - (height * (j + 0.5)) / POINTS_DOWN,
        -1,
      ];
      const way = rotate(later.orientation, ray);
      const point = add(later.position, scale(way, distance));
      const moved = placeOf(fromWorld, subtract(point, traced.position));
      if (
        !moved ||
        moved[0] < -traced.tanLeft ||
        moved[0] > traced.tanRight ||
        moved[1] < -traced.tanDown ||
        moved[1] > traced.tanUp
      ) {
        sum.unseen += 1;
        continue;
      }
      const turned = placeOf(fromWorld, way);
      if (!turned) continue;
      sum.turn += Math.hypot(turned[0] - ray[0], turned[1] - ray[1]) / width;
      sum.shift += Math.hypot(turned[0] - moved[0], turned[1] - moved[1]) / width;
    }
  }
  const points = POINTS_ACROSS * POINTS_DOWN;
  return { unseen: sum.unseen / points, turn: sum.turn / points, shift: sum.shift / points };
}
