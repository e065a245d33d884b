// Where a person stands and looks: a position, and an orientation without roll.
import { aboutAxis, add, multiply, rotate, scale } from '../prediction/vector.js';

const MOST_PITCH = Math.PI / 2 - 0.01;

export class Gaze {
  /** Angles are radians. @param {{position: number[], yaw: number, pitch: number, verticalFov: number}} start */
  constructor({ position, yaw, pitch, verticalFov }) {
    this.position = position;
    this.yaw = yaw;
    this.pitch = pitch;
    this.verticalFov = verticalFov;
  }

  /** @param {import('../prediction/border.js').Pose} pose */
  static of(pose) {
    return Gaze.along(pose.position, rotate(pose.orientation, [0, 0, -1]), pose.verticalFov);
  }

  /** @param {number[]} position @param {number[]} forward unit @param {number} verticalFov radians */
  static along(position, [x, y, z], verticalFov) {
    const pitch = Math.asin(Math.max(-1, Math.min(1, y)));
    return new Gaze({ position: [...position], yaw: Math.atan2(-x, -z), pitch, verticalFov });
  }

  get orientation() {
    return multiply(aboutAxis(this.yaw, [0, 1, 0]), aboutAxis(this.pitch, [1, 0, 0]));
  }

  /** The orientation of a person who looks straight ahead. */
  get level() {
    return aboutAxis(this.yaw, [0, 1, 0]);
  }

  /** @returns {import('../prediction/border.js').Pose} */
  get pose() {
    return { position: [...this.position], orientation: this.orientation, verticalFov: this.verticalFov };
  }

  /** @param {number} left radians @param {number} up radians */
  turn(left, up) {
    this.yaw = (this.yaw + left) % (2 * Math.PI);
    this.pitch = Math.max(-MOST_PITCH, Math.min(MOST_PITCH, this.pitch + up));
  }

  /** Along the camera's own axes. @param {number} right metres @param {number} up @param {number} forward */
  move(right, up, forward) {
    const along = rotate(this.orientation, [right, 0, -forward]);
    this.position = add(add(this.position, along), [0, up, 0]);
  }

  /** Brings the position into a box. @param {number[]} least @param {number[]} most */
  keepWithin(least, most) {
    this.position = this.position.map((part, i) => Math.max(least[i], Math.min(most[i], part)));
  }
}

/** The gaze on a slow circle around the middle of a box. @param {number[]} least @param {number[]} most @param {number} turn */
export function orbit(least, most, turn, verticalFov = 0.9) {
  const middle = scale(add(least, most), 0.5);
  const reach = 0.25 * Math.hypot(most[0] - least[0], most[2] - least[2]);
  const position = [middle[0] + reach * Math.sin(turn), middle[1], middle[2] + reach * Math.cos(turn)];
  return new Gaze({ position, yaw: turn, pitch: 0, verticalFov });
}
