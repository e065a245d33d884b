// A flight along the scene's own camera animation, or on a slow circle where it has none.
import { localTransform, product } from '../pack/matrices.js';
import { sample } from '../pack/motion.js';
import { Gaze, orbit } from './gaze.js';

const ORBIT_SECONDS = 40;

/** A camera's path, as web/PACK.md has it, with its numbers at hand. */
class Path {
  /** @param {import('../pack/pack.js').ScenePack} pack @param {any} path */
  constructor(pack, path) {
    this.seconds = path.duration_s;
    this.verticalFov = pack.info.cameras[path.camera].vertical_fov;
    this.chain = path.chain;
    this.channels = path.channels.map((/** @type {any} */ channel) => ({
      ...channel,
      times: pack.floats(channel.times),
      values: pack.floats(channel.values),
    }));
  }

  /** @param {number} seconds */
  gazeAt(seconds) {
    const nodes = this.chain.map((/** @type {any} */ node) => ({ ...node }));
    for (const channel of this.channels) nodes[channel.node][channel.path] = sample(channel, seconds);
    const m = nodes.map(localTransform).reduce((/** @type {any} */ a, /** @type {any} */ b) => product(a, b));
    const back = [m[8], m[9], m[10]];
    const size = Math.hypot(...back) || 1;
    return Gaze.along(
      [m[12], m[13], m[14]],
      back.map((part) => -part / size),
      this.verticalFov,
    );
  }
}

export class Flight {
  /** @param {import('../pack/pack.js').ScenePack} pack */
  constructor(pack) {
    const path = pack.info.camera_paths[0];
    this.path = path ? new Path(pack, path) : null;
    this.bounds = pack.info.bounds;
    this.seconds = 0;
  }

  /** The gaze after another `seconds` of flight. @param {number} seconds */
  step(seconds) {
    this.seconds += seconds;
    if (this.path) return this.path.gazeAt(this.seconds % this.path.seconds);
    return orbit(this.bounds.min, this.bounds.max, (2 * Math.PI * this.seconds) / ORBIT_SECONDS);
  }
}
