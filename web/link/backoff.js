// How long a client that lost its server waits before it connects again: doubled each time. Reads no clock.

const FIRST = 250; // milliseconds
const LONGEST = 8_000;

/** Codes of Refused that may pass: the scene did not load, too many sessions, over capacity, draining, internal. */
const MAY_PASS = new Set([6, 8, 9, 11, 12]);

export class Backoff {
  constructor() {
    this.next = FIRST;
  }

  /**
   * Milliseconds to wait after a failure; null if another attempt would fail too.
   * @param {{code: number} | null} refusal the server's, if it refused
   */
  waitAfter(refusal) {
    return refusal && !MAY_PASS.has(refusal.code) ? null : this.wait();
  }

  /** Milliseconds to wait after a failure of the network. */
  wait() {
    const wait = this.next;
    this.next = Math.min(2 * wait, LONGEST);
    return wait;
  }

  connected() {
    this.next = FIRST;
  }
}
