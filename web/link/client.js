// A session that is opened again when it is lost, after a while that grows. Where the server is full it asks for fewer
// pictures, and tells the page if only fewer pixels would help. Runs in a worker. The page keeps its last picture meanwhile.
//
// Where its server drains in a fleet, another session is opened at the door, and takes the place of the first with its
// first frame: the page sees one that goes on.
import { KEPT_OUT } from '../wire/messages.js';
import { Backoff } from './backoff.js';
import { Move } from './move.js';
import { Session } from './session.js';

const LEAST_RATE_HZ = 10; // below, fewer pixels are better than fewer pictures

/** @typedef {{is: string} & Record<string, any>} Event */

export class Client {
  /**
   * @param {object} parts
   * @param {(url: string) => WebSocket} parts.connect
   * @param {((url: string, options: object) => any) | null} [parts.dial] makes a WebTransport; null where there is none
   * @param {import('../decoder.js').Decoder} parts.decoder
   * @param {() => import('./lanes.js').Lanes | null} [parts.lanes] as in Session
   * @param {(event: Event, transfer?: Transferable[]) => void} parts.emit
   * @param {() => number} parts.now milliseconds
   * @param {Move} [parts.move]
   */
  constructor({ connect, dial = null, decoder, lanes, emit, now, move = new Move() }) {
    this.connect = connect;
    this.dial = dial;
    this.decoder = decoder;
    this.lanes = lanes;
    this.emit = emit;
    this.now = now;
    this.backoff = new Backoff();
    /** @type {Session | null} */
    this.session = null;
    this.retry = /** @type {any} */ (0);
    this.move = move;
    this.moveTimer = /** @type {any} */ (0);
    /** @type {Session | null} */
    this.successor = null; // takes the place of the session with its first frame
    /** @type {Map<string, Event>} what the successor has told, the newest of each kind, the first of them `open` */
    this.told = new Map();
    this.shown = -1; // index of the newest frame
    this.ended = ''; // why the session that was open last is no longer, until another one is
    this.url = '';
    /** @type {import('../wire/messages.js').Hello | null} */
    this.hello = null;
    /** @type {{index: number, camera: import('../wire/camera.js').Camera} | null} */
    this.last = null;
  }

  /** @param {string} url of the WebSocket @param {import('../wire/messages.js').Hello} hello */
  open(url, hello) {
    this.close('another session is opened');
    this.url = url;
    this.hello = hello;
    this.backoff.connected();
    this.shown = -1;
    this.ended = '';
    this.begin();
  }

  begin() {
    this.emit({ is: 'connecting' });
    this.session = this.make();
  }

  make() {
    const hello = /** @type {import('../wire/messages.js').Hello} */ (this.hello);
    const session = new Session({
      socket: this.connect(this.url),
      dial: this.dial,
      decoder: this.decoder,
      lanes: this.lanes,
      hello,
      now: this.now,
      emit: (event, transfer) => {
        if (session === this.session) this.on(event, transfer);
        else if (session === this.successor) this.onSuccessor(event, transfer);
      },
    });
    return session;
  }

  beginMove() {
    this.told.clear();
    this.successor = this.make();
  }

  /** @param {Event} draining */
  onDrain(draining) {
    const wait = this.move.told(/** @type {any} */ (draining));
    if (wait !== null) this.moveTimer = setTimeout(() => this.beginMove(), wait);
    if (!this.move.wanted) this.giveUpMove('the server goes on');
  }

  /** @param {string} reason */
  giveUpMove(reason) {
    this.move.moved();
    clearTimeout(this.moveTimer);
    const successor = this.successor;
    this.successor = null;
    successor?.close(reason);
  }

  /** @param {Event} event @param {Transferable[]} [transfer] */
  onSuccessor(event, transfer) {
    if (event.is === 'closed') {
      this.successor = null;
      if (event.refusal?.code !== KEPT_OUT) this.moveTimer = setTimeout(() => this.beginMove(), this.move.waitAfter());
    } else if (event.is === 'frame') {
      this.takeOver();
      if (event.index > this.shown) this.on(event, transfer); // else the session before has answered it
    } else if (event.is !== 'waiting') {
      this.told.set(event.is, event);
      if (event.is === 'open' && this.last) this.successor?.look(this.last.index, this.last.camera);
    }
  }

  /** The successor is the session from now on. */
  takeOver() {
    const before = this.session;
    this.session = this.successor;
    this.successor = null;
    this.move.moved();
    clearTimeout(this.moveTimer);
    before?.close('moved to another server of the fleet');
    for (const event of this.told.values()) {
      if (event.is === 'draining') this.onDrain(event);
      this.emit(event);
    }
  }

  /** Whether another session takes the place of one that has ended while its client was to move. @param {Event} closed */
  goesOn(closed) {
    if (!this.move.wanted || closed.refusal || closed.stayOutMs > 0) return false;
    if (!this.successor) this.beginMove();
    this.takeOver();
    return true;
  }

  /** @param {Event} event @param {Transferable[]} [transfer] */
  on(event, transfer) {
    if (event.is === 'open') {
      this.backoff.connected();
      this.ended = '';
      if (this.last) this.session?.look(this.last.index, this.last.camera);
    }
    if (event.is === 'draining') this.onDrain(event);
    if (event.is === 'frame') this.shown = event.index;
    if (event.is !== 'closed') return this.emit(event, transfer);
    if (this.goesOn(event)) return;
    this.giveUpMove(event.why);
    this.session = null;
    const slower = event.refusal?.fitRateHz ?? 0; // what would have fitted at the size asked for
    if (slower >= LEAST_RATE_HZ && this.hello && slower < this.hello.rateHz) {
      this.hello = { ...this.hello, rateHz: slower };
      return this.begin();
    }
    if (event.tooLarge && (this.hello?.samples ?? 1) > 1) {
      this.hello = { .../** @type {import('../wire/messages.js').Hello} */ (this.hello), samples: 1 };
      return this.begin();
    }
    const fits = event.refusal && event.refusal.fitWidth > 0 && event.refusal.fitWidth < (this.hello?.width ?? 0);
    if (fits) {
      const { fitWidth, fitHeight } = event.refusal;
      this.emit({ is: 'fits', width: fitWidth, height: fitHeight, text: event.refusal.text });
      return;
    }
    const keptOut = event.stayOutMs > 0 || event.refusal?.code === KEPT_OUT;
    const wait = keptOut ? null : this.backoff.waitAfter(event.refusal);
    // That a token was revoked says more than the refusal of a stranger, as who comes again with it is.
    const why = event.refusal && this.ended ? `${this.ended}; and a new one: ${event.why}` : event.why;
    if (!event.refusal) this.ended ||= event.why;
    this.emit({ ...event, why, againInMs: wait });
    if (wait !== null) this.retry = setTimeout(() => this.begin(), wait);
  }

  /** @param {number} index @param {import('../wire/camera.js').Camera} camera */
  look(index, camera) {
    this.last = { index, camera };
    this.session?.look(index, camera);
    this.successor?.look(index, camera);
  }

  /** @param {string} reason */
  close(reason) {
    clearTimeout(this.retry);
    this.giveUpMove(reason);
    const session = this.session;
    this.session = null;
    session?.close(reason);
  }
}
