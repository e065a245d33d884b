// When a client whose server drains asks the door of its fleet for another session (protocol/WIRE.md, Moving). Reads no
// clock: times are in milliseconds.

const LONGEST_SPREAD = 2_000; // the clients of a server are told all at once, and come to the door one by one
const FIRST_RETRY = 300;
const LONGEST_RETRY = 4_000;

export class Move {
  /** @param {() => number} random from 0 to 1 */
  constructor(random = Math.random) {
    this.random = random;
    this.wanted = false;
    this.retry = FIRST_RETRY;
  }

  /**
   * The server has said that it drains. For how long to wait before the door is asked; null if nothing is to be begun.
   * @param {{deadlineMs: number, moveNow: boolean}} draining
   */
  told({ deadlineMs, moveNow }) {
    const begins = moveNow && !this.wanted;
    this.wanted = moveNow;
    if (!begins) return null;
    this.retry = FIRST_RETRY;
    return this.random() * Math.min(LONGEST_SPREAD, deadlineMs / 10);
  }

  /** An attempt has failed. For how long to wait before the next. */
  waitAfter() {
    const wait = this.retry * (1 + this.random());
    this.retry = Math.min(2 * this.retry, LONGEST_RETRY);
    return wait;
  }

  moved() {
    this.wanted = false;
  }
}
