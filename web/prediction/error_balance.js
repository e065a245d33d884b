// Chooses which camera to show: of all that could be, the one with the least sum of expected error and cost of its age.
// The expected error is a function of the motion since the masks' camera, whose four coefficients are learned from
// predictions whose masks have arrived since, by recursive least squares that forgets. As
// client/prediction/error_balance.h of the native client.
import { motionBetween } from './motion.js';

// Initial and greatest variance of each weight, relative to that of the errors.
const MOST_TRUST = [3, 4000, 1000, 10000];
const FORGET = 0.002; // share of MOST_TRUST that each error restores
const MOST_WEIGHT = 2;
const TERMS = 4;
const MOST_AHEAD = 19; // the largest number of frames ahead that the dissertation measured

/** The expected share of wrong bits of a prediction, as a function of the motion. */
export class ErrorCurve {
  /** @param {import('./border.js').ViewSize} size */
  constructor(size) {
    this.width = size.width;
    this.weights = [0.005, 0.35, 0.02, 0.1];
    this.trust = MOST_TRUST.map((most, i) => MOST_TRUST.map((_, j) => (i === j ? most : 0)));
  }

  /** @param {import('./motion.js').ImageMotion} motion */
  terms(motion) {
    return [Math.min(1, this.width * (motion.turn + motion.shift)), motion.unseen, motion.turn, motion.shift];
  }

  /** @param {import('./motion.js').ImageMotion} motion */
  expect(motion) {
    return Math.min(
      this.terms(motion).reduce((sum, term, i) => sum + this.weights[i] * term, 0),
      1,
    );
  }

  /** @param {import('./motion.js').ImageMotion} motion @param {number} error share of wrong bits */
  learn(motion, error) {
    const terms = this.terms(motion);
    if (terms[0] < 1e-3) return; // a resting camera carries no information
    const reach = this.trust.map((row) => row.reduce((sum, trust, j) => sum + trust * terms[j], 0));
    let spread = 1,
      expected = 0;
    for (let i = 0; i < TERMS; ++i) {
      spread += terms[i] * reach[i];
      expected += this.weights[i] * terms[i];
    }
    this.weights = this.weights.map((weight, i) =>
      Math.min(Math.max(weight + (reach[i] / spread) * (error - expected), 0), MOST_WEIGHT),
    );
    for (let i = 0; i < TERMS; ++i) {
      for (let j = 0; j < TERMS; ++j) this.trust[i][j] -= (reach[i] * reach[j]) / spread;
      this.trust[i][i] = Math.min(MOST_TRUST[i], this.trust[i][i] + FORGET * MOST_TRUST[i]);
    }
  }
}

/** @typedef {{index: number, camera: import('../wire/camera.js').Camera, asked: number}} RequestedCamera asked: ms */

export class ErrorBalance {
  /** @param {{size: import('./border.js').ViewSize, distance?: number, costPerSecond?: number}} options */
  constructor({ size, distance = 4, costPerSecond = 0.15 }) {
    this.size = size;
    this.distance = distance;
    this.costPerSecond = costPerSecond;
    this.curve = new ErrorCurve(size);
  }

  /**
   * The index, in `cameras`, of the one to show.
   * @param {RequestedCamera[]} cameras the first: the newest with masks; the last: the newest
   * @param {number} least the index shown last: pictures never go back
   * @param {number} now ms
   */
  choose(cameras, least, now) {
    const most = Math.max(least, Math.min(cameras.length - 1, MOST_AHEAD));
    let [best, leastCost] = [least, Infinity];
    for (let i = least; i <= most; ++i) {
      const error = this.curve.expect(motionBetween(cameras[0].camera, cameras[i].camera, this.size, this.distance));
      const cost = error + (this.costPerSecond * (now - cameras[i].asked)) / 1000;
      if (cost <= leastCost) [best, leastCost] = [i, cost]; // ties go to the newer one
    }
    return best;
  }

  /**
   * How wrong a prediction was, once the masks of its camera have arrived.
   * @param {import('../wire/camera.js').Camera} earlier @param {import('../wire/camera.js').Camera} later
   * @param {number} error share of wrong bits
   */
  observe(earlier, later, error) {
    this.curve.learn(motionBetween(earlier, later, this.size, this.distance), error);
  }
}
