// Chooses how many pixels are drawn and traced for each pixel of the screen: fewer where the device is too slow, more
// again where it has room. No clock: times are arguments, in milliseconds.

const STEPS = [1, 0.75, 0.5, 0.375]; // of the screen's pixels, each way
const SLOW = 1000 / 24; // of a picture: below, what moves looks like single pictures
const FAST = 1000 / 55;
const SLOW_FOR = 2_000; // so long it must be slow before pixels go
const FAST_FOR = 15_000; // and so long fast before they come back
const MOST_RATIO = 2; // device pixels for a pixel of the page
const ALIGN = 8; // sizes are whole tiles

export class Quality {
  constructor() {
    this.step = 0;
    this.automatic = true;
    this.slowSince = /** @type {number | null} */ (null);
    this.fastSince = /** @type {number | null} */ (null);
    this.mean = /** @type {number | null} */ (null);
    this.worstStep = 0; // steps that were given up are not tried again at once
  }

  get scale() {
    return STEPS[this.step];
  }

  /**
   * A picture took `took` milliseconds to draw. Returns whether the scale has changed.
   * @param {number} took @param {number} now
   */
  drawn(took, now) {
    this.mean = this.mean === null ? took : this.mean + (took - this.mean) / 8;
    if (!this.automatic) return false;
    this.slowSince = this.mean > SLOW ? (this.slowSince ?? now) : null;
    this.fastSince = this.mean < FAST ? (this.fastSince ?? now) : null;
    if (this.slowSince !== null && now - this.slowSince > SLOW_FOR && this.coarser()) return true;
    const patience = FAST_FOR * (1 + this.worstStep);
    if (this.fastSince !== null && now - this.fastSince > patience && this.step > 0) {
      this.worstStep += 1;
      return this.become(this.step - 1);
    }
    return false;
  }

  /** Fewer pixels from now on. False if there is no coarser step. */
  coarser() {
    return this.step + 1 < STEPS.length && this.become(this.step + 1);
  }

  /** @param {number} step */
  become(step) {
    this.step = step;
    this.slowSince = this.fastSince = this.mean = null;
    return true;
  }

  /**
   * The picture's size in pixels, of a place on the page.
   * @param {number} width CSS pixels @param {number} height @param {number} ratio device pixels for each
   */
  size(width, height, ratio) {
    const by = Math.min(ratio, MOST_RATIO) * this.scale;
    const side = (length) => Math.max(ALIGN * 8, Math.floor((length * by) / ALIGN) * ALIGN);
    return { width: side(width), height: side(height) };
  }
}

/** The border that is traced around a picture: a twentieth of it each way, in whole tiles. @param {number} side */
export const borderOf = (side) => Math.round(side / 20 / 16) * 16;
