// Decides which camera is shown next, and with whose masks. No clock, no network. As client/prediction/show_order.h of
// the native client.

// A server may never answer, or stop to: beyond so many cameras the oldest is forgotten, and its masks with it.
const MOST_CAMERAS = 4096;

export class ShowOrder {
  /**
   * @param {{choose: (cameras: import('./error_balance.js').RequestedCamera[], least: number, now: number) => number}}
   *   ahead chooses, of the cameras since the newest with masks, the one to show
   */
  constructor(ahead) {
    this.ahead = ahead;
    this.count = 0;
    /** @type {import('./error_balance.js').RequestedCamera[]} from the newest with masks on, once there is one */
    this.cameras = [];
    this.anySeen = false;
    /** @type {{camera: number, seen: number} | null} indices shown last */
    this.last = null;
  }

  /** Returns the camera's index. @param {import('../wire/camera.js').Camera} camera @param {number} now ms */
  asked(camera, now) {
    this.cameras.push({ index: this.count, camera, asked: now });
    if (this.cameras.length > MOST_CAMERAS) {
      this.cameras.shift();
      this.anySeen = false;
    }
    return this.count++;
  }

  /** The masks of a camera have arrived. False if these or newer ones had before. @param {number} index */
  answered(index) {
    if (this.cameras.length === 0 || index < this.cameras[0].index || index >= this.count) return false;
    if (this.anySeen && index === this.cameras[0].index) return false;
    this.cameras.splice(0, index - this.cameras[0].index);
    this.anySeen = true;
    return true;
  }

  /**
   * Null if no masks have arrived yet, or there is nothing else to show than last time.
   * @param {number} now ms
   */
  next(now) {
    if (!this.anySeen) return null;
    const seen = this.cameras[0];
    const least = this.last && this.last.camera > seen.index ? this.last.camera - seen.index : 0;
    const camera = this.cameras[this.ahead.choose(this.cameras, least, now)];
    if (this.last && this.last.camera === camera.index && this.last.seen === seen.index) return null;
    this.last = { camera: camera.index, seen: seen.index };
    return { camera, seen, newest: this.count - 1, reprojected: camera.index !== seen.index };
  }

  /** The newest camera that was asked for; null before the first. */
  get newest() {
    return this.cameras.length > 0 ? this.cameras[this.cameras.length - 1] : null;
  }
}
