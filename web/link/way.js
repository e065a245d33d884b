// Which way a session's cameras and slices go: over its WebSocket, or as datagrams by WebTransport. A network may let no
// UDP pass, stop doing so, or lose more of it than congestion control bears; and may come to pass it again. No clock:
// times are arguments, in milliseconds.

const SILENCE = 2_000; // without a datagram while an answer is awaited
const LOSS = 0.02; // above it WebSockets with credit are the better way (docs/browser.md)
const LOSS_WINDOW = 1_000; // datagrams
const FIRST_PAUSE = 2_000;
const PAUSE_AFTER_LOSS = 30_000;
const LONGEST_PAUSE = 60_000;
const PROVED = 10_000; // so long datagrams have served well: the next pause is a first one again

export class Way {
  constructor() {
    this.pause = FIRST_PAUSE;
    this.nextTry = 0;
    this.enteredAt = 0;
    this.lastArrival = 0;
    /** @type {number | null} since when an answer is awaited */
    this.awaitedSince = null;
    this.first = 0n; // sequence numbers of the window in which losses are counted; 0: none has come
    this.newest = 0n;
    this.arrived = 0;
    this.loss = 0;
  }

  /** @param {bigint} sequence of the window's first datagram */
  restart(sequence) {
    this.first = this.newest = sequence;
    this.arrived = 0;
  }

  /** Whether another connection may be tried. @param {number} now */
  mayTry(now) {
    return now >= this.nextTry;
  }

  /** Datagrams are the way from now on. @param {number} now */
  enter(now) {
    this.enteredAt = this.lastArrival = now;
    this.awaitedSince = null;
    this.loss = 0;
    this.restart(0n);
  }

  /** A camera was sent that is to be answered. @param {number} now */
  asked(now) {
    this.awaitedSince ??= now;
  }

  /** A frame is whole. `more`: others are still under way. @param {boolean} more @param {number} now */
  answered(more, now) {
    this.awaitedSince = more ? now : null;
  }

  /** @param {bigint} sequence of a datagram @param {number} now */
  received(sequence, now) {
    this.lastArrival = now;
    if (this.first === 0n) this.restart(sequence);
    if (sequence >= this.first) this.arrived += 1;
    if (sequence > this.newest) this.newest = sequence;
    const sent = Number(this.newest - this.first) + 1;
    if (sent < LOSS_WINDOW) return;
    this.loss = 1 - this.arrived / sent;
    this.restart(this.newest + 1n);
  }

  /** Why datagrams should be the way no more; null: they serve. @param {number} now */
  complaint(now) {
    if (this.awaitedSince !== null && now - Math.max(this.awaitedSince, this.lastArrival) > SILENCE) return 'silence';
    return this.loss > LOSS ? 'loss' : null;
  }

  /** They are the way no more, or did not become it. @param {string} why @param {number} now */
  leave(why, now) {
    if (this.enteredAt > 0 && now - this.enteredAt > PROVED) this.pause = FIRST_PAUSE;
    this.enteredAt = 0;
    const pause = why === 'loss' ? Math.max(this.pause, PAUSE_AFTER_LOSS) : this.pause;
    this.nextTry = now + pause;
    this.pause = Math.min(2 * pause, LONGEST_PAUSE);
  }
}
