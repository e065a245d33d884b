// One eye of a person: asks one session for masks of what it sees, and says which camera to show and with whose masks.
// A page has one, a headset two, each with a session of its own: in one session the newest camera would replace that of
// the other eye.
//
//   look(camera) -> worker ... frame -> ShowOrder -> next()
import { Backoff } from './link/backoff.js';
import { shownPart, tracedHeight, tracedWidth } from './prediction/border.js';
import { ErrorBalance } from './prediction/error_balance.js';
import { ShowOrder } from './prediction/show_order.js';
import { Codec } from './wire/messages.js';
import { OCCLUSION } from './wire/planes.js';

const CLIENT = 'gnomon-web';
export const MOST_RATE_HZ = 60;

/**
 * @typedef {import('./wire/camera.js').Camera} Camera
 * @typedef {import('./prediction/border.js').ViewSize} ViewSize
 * @typedef {{scene: string, tenant: string, token: string}} Wanted
 * @typedef {import('./prediction/error_balance.js').RequestedCamera} RequestedCamera
 * @typedef {{camera: RequestedCamera, seen: RequestedCamera | null, newest: number, reprojected: boolean}} Shown
 */

export class Eye {
  /**
   * @param {URL} base of the page
   * @param {(event: {is: string} & Record<string, any>) => void} emit the worker's events
   * @param {number} share of the processors that decoding may use
   */
  constructor(base, emit, share = 1) {
    this.base = base;
    this.emit = emit;
    this.processors = share * (navigator.hardwareConcurrency ?? 1);
    this.backoff = new Backoff();
    this.restart = /** @type {any} */ (0);
    /** @type {object | null} what opened the session */
    this.opening = null;
    this.worker = this.startWorker();
    /** @type {Shown | null} what was shown last */
    this.drawn = null;
    /** @type {ViewSize} */
    this.size = { width: 64, height: 64, borderX: 0, borderY: 0 };
    this.balance = new ErrorBalance({ size: this.size });
    this.order = new ShowOrder(this.balance);
    /** @type {any} the newest whole frame */
    this.masks = null;
    this.session = 0; // counts them, and the scenes of each
    /** @type {{masks: any, until: number} | null} masks whose prediction is to be judged */
    this.trial = null;
  }

  /** @private */
  startWorker() {
    const worker = new Worker(new URL('worker.js', this.base), { type: 'module' });
    worker.onmessage = ({ data }) => this.on(data);
    worker.onerror = ({ message }) => this.onWorkerError(message);
    return worker;
  }

  /**
   * Without a message, one of its modules did not come: another worker asks for it again.
   * @private @param {string | undefined} message
   */
  onWorkerError(message) {
    if (message) return this.emit({ is: 'failed', why: message });
    const wait = this.backoff.wait();
    this.emit({ is: 'closed', why: 'a part of the page did not come', refusal: null, againInMs: wait });
    this.restart = setTimeout(() => {
      this.worker = this.startWorker();
      if (this.opening) this.worker.postMessage(this.opening);
    }, wait);
  }

  /** What was seen at another size is of no use any more. @param {ViewSize} size */
  setSize(size) {
    this.size = size;
    this.balance = new ErrorBalance({ size });
    this.order = new ShowOrder(this.balance);
    this.masks = this.trial = this.drawn = null;
  }

  /**
   * Opens a session; the one before is closed.
   * @param {Wanted} wanted
   * @param {{codec: keyof typeof Codec, samples: number, occlusion: import('./wire/planes.js').Occlusion}} masks
   *   samples: points of an area light
   */
  connect(wanted, { codec, samples, occlusion }, rateHz = MOST_RATE_HZ) {
    const socket = new URL('session', this.base);
    socket.protocol = socket.protocol === 'http:' ? 'ws:' : 'wss:';
    this.opening = {
      do: 'open',
      url: socket.href,
      processors: this.processors,
      hello: {
        client: CLIENT,
        tenant: wanted.tenant,
        token: wanted.token,
        scene: wanted.scene,
        width: tracedWidth(this.size),
        height: tracedHeight(this.size),
        borderX: this.size.borderX,
        borderY: this.size.borderY,
        rateHz,
        codecs: [Codec[codec], Codec.tiles_lz4],
        samples: samples + OCCLUSION[occlusion],
      },
    };
    this.worker.postMessage(this.opening);
  }

  /** @param {any} event */
  on(event) {
    if (event.is === 'open' || event.is === 'sceneChanged') ++this.session;
    if (event.is === 'frame') {
      // A view at rest is asked for again where lights, quality or the session change: the same camera, newer masks.
      if (!this.order.answered(event.index) && event.index !== this.masks?.index) return;
      event.session = this.session;
      this.masks = event;
    }
    this.emit(event);
  }

  /**
   * The camera of now, of the traced buffer. `asks`: masks of it are wanted.
   * @param {Camera} camera
   * @param {number} now milliseconds
   */
  look(camera, now, asks = true) {
    const index = this.order.asked(camera, now);
    if (asks) this.worker.postMessage({ do: 'look', index, camera });
  }

  /** Asks for masks of the newest camera, which was not asked for. */
  lookAgain() {
    const { newest } = this.order;
    if (newest) this.worker.postMessage({ do: 'look', index: newest.index, camera: newest.camera });
  }

  /** The newest camera, without masks. @returns {Shown | null} */
  get plain() {
    const { newest } = this.order;
    return newest && { camera: newest, seen: null, newest: newest.index, reprojected: false };
  }

  /** The picture's part of a camera. @param {Shown} shown */
  shownCamera(shown) {
    return shownPart(shown.camera.camera, this.size);
  }

  /**
   * From predictions whose masks have come since, the balance learns. Called for each picture.
   * @param {import('./render/renderer.js').Renderer} renderer
   */
  async judge(renderer) {
    const { masks, trial, balance } = this;
    if (!masks) return;
    if (!trial) {
      this.trial = { masks, until: this.order.count - 1 };
      return;
    }
    if (masks.index < trial.until || masks.index === trial.masks.index) return;
    this.trial = null;
    if (trial.masks.width !== masks.width || trial.masks.height !== masks.height) return;
    const error = await renderer.outcome(trial.masks, masks, shownPart(masks.camera, this.size), this.size);
    if (error !== null) balance.observe(trial.masks.camera, masks.camera, error);
  }

  close() {
    clearTimeout(this.restart);
    this.worker.postMessage({ do: 'close', reason: 'the page was closed' });
  }
}
