// How many cameras may be under way: the newest camera waits while `limit` frames are not yet whole. Without this a
// bottleneck fills the buffers of TCP, and pictures come a second late instead of less often. No clock: times are
// arguments, in milliseconds.

const FIRST_PATIENCE = 10_000; // before anything is known of the server
const LEAST_PATIENCE = 1_000;
const FORGOTTEN = 256; // frames; older ones are not answered any more

/** @typedef {{frame: number, index: number, camera: import('../wire/camera.js').Camera, sent: number}} Request */

export class Credit {
  /** @param {{limit: number, rateHz: number}} options rateHz 0: as fast as answers come */
  constructor({ limit, rateHz }) {
    this.limit = limit;
    this.rateHz = rateHz;
    /** @type {Map<number, Request>} by frame, those that may still be answered */
    this.requests = new Map();
    this.newest = 0;
    this.newestWhole = 0;
    this.lastSent = -Infinity;
    this.nextByRate = -Infinity;
    /** @type {number | null} */
    this.mean = null;
    this.deviation = 0;
  }

  get inFlight() {
    return this.newest - this.newestWhole;
  }

  /** How long a full window waits for an answer: as TCP's retransmission timer (RFC 6298). */
  get patience() {
    return this.mean === null ? FIRST_PATIENCE : Math.max(LEAST_PATIENCE, this.mean + 4 * this.deviation);
  }

  /** The earliest time at which the next camera may be sent. */
  get opensAt() {
    return this.inFlight >= this.limit ? Math.max(this.nextByRate, this.lastSent + this.patience) : this.nextByRate;
  }

  /** @param {number} now */
  isOpen(now) {
    return this.opensAt <= now;
  }

  /**
   * Returns the camera's frame number.
   * @param {number} index @param {import('../wire/camera.js').Camera} camera @param {number} now
   */
  sent(index, camera, now) {
    const frame = ++this.newest;
    this.requests.set(frame, { frame, index, camera, sent: now });
    this.requests.delete(frame - FORGOTTEN);
    this.lastSent = now;
    const interval = this.rateHz > 0 ? 1000 / this.rateHz : 0;
    this.nextByRate = frame === 1 ? now + interval : Math.max(this.nextByRate + interval, now);
    return frame;
  }

  /** What is under way is given up. */
  forget() {
    this.newestWhole = this.newest;
    this.requests.clear();
  }

  /**
   * A frame has arrived whole. Null if it is none that was asked for, or a newer one came before.
   * @param {number} frame @param {number} now
   * @returns {Request | null}
   */
  whole(frame, now) {
    const request = this.requests.get(frame);
    if (!request || frame <= this.newestWhole) return null;
    this.newestWhole = frame;
    for (const older of this.requests.keys()) if (older <= frame) this.requests.delete(older);
    const response = now - request.sent;
    if (this.mean === null) {
      [this.mean, this.deviation] = [response, response / 2];
    } else {
      this.deviation = (3 * this.deviation + Math.abs(this.mean - response)) / 4;
      this.mean = (7 * this.mean + response) / 8;
    }
    return request;
  }
}
