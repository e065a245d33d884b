// One session with a daemon: Hello, cameras out, frames in. Its control is one WebSocket, and so is the way of its cameras
// and slices unless link/carrier.js finds a better one. It reconnects nothing; link/client.js does.
//
//   look(camera) -> CameraUpdate, as soon as there is credit ... slices -> decoder -> frame
//
// Runs in a worker, so that decoding holds up no picture. What happened is told by events, each an object with `is`.
import { Codec, decode, encodeBye, encodeHello } from '../wire/messages.js';
import { Malformed } from '../wire/bytes.js';
import { fewest, planesOf } from '../wire/planes.js';
import { Carrier } from './carrier.js';
import { Credit } from './credit.js';

const CREDIT = 3; // frames under way: measured best but at a bottleneck, where two are (docs/browser.md)
const CREDIT_WHEN_SLOW = 2;
const SLOW = 60; // milliseconds of mean response above the least one: something queues
const SIGNS_OF_LIFE = 3; // within the server's patience with silent clients
const KEPT_LIGHTS = 16; // versions
const POLL = 8; // milliseconds; a timer of a page is no finer

export class Session {
  /**
   * @param {object} parts
   * @param {WebSocket} parts.socket connecting or open, of the subprotocol `gnomon`
   * @param {((url: string, options: object) => any) | null} [parts.dial] makes a WebTransport
   * @param {import('../decoder.js').Decoder} parts.decoder
   * @param {(() => import('./lanes.js').Lanes | null)} [parts.lanes] workers that decode beside this one
   * @param {import('../wire/messages.js').Hello} parts.hello
   * @param {(event: {is: string} & Record<string, any>, transfer?: Transferable[]) => void} parts.emit
   * @param {() => number} parts.now milliseconds
   */
  constructor({ socket, dial = null, decoder, lanes = () => null, hello, emit, now }) {
    this.socket = socket;
    this.decoder = decoder;
    this.makeLanes = lanes;
    /** @type {import('./lanes.js').Lanes | null} */
    this.lanes = null;
    this.hello = hello;
    this.emit = emit;
    this.now = now;
    this.credit = new Credit({ limit: CREDIT, rateHz: 0 });
    this.leastResponse = Infinity;
    /** @type {any} */
    this.welcome = null;
    /** @type {any} */
    this.refusal = null;
    this.stayOutMs = 0;
    this.tooLarge = false;
    this.why = '';
    /** @type {import('../decoder.js').MaskStream | null} null before Welcome */
    this.stream = null;
    this.shape = { width: 0, height: 0, samples: 0 };
    this.planes = planesOf([], 1);
    this.firstFrame = 1; // older ones are of a grid that is no more
    /** @type {Map<number, object[]>} lights by version */
    this.lights = new Map();
    /** @type {{index: number, camera: import('../wire/camera.js').Camera} | null} */
    this.wanted = null; // the newest camera that was not sent
    this.newest = null; // the update sent last
    this.lastSaid = -Infinity; // when it was sent, be it as a sign of life; patience counts from Credit.lastSent
    /** @type {{index: number, camera: import('../wire/camera.js').Camera} | null} what it was made of */
    this.asked = null;
    this.counters = { bytes: 0, frames: 0, malformed: 0 };
    this.ended = false;
    socket.binaryType = 'arraybuffer';
    this.carrier = new Carrier({
      socket,
      dial,
      now,
      onSlice: (body) => {
        if (body.length >= 4) this.onSlice(body); // else it is dropped, as a datagram that is malformed
      },
      onChange: () => this.changeWay(),
    });
    socket.onopen = () => socket.send(encodeHello({ ...hello, webTransport: dial !== null }));
    socket.onmessage = (event) => this.receive(event.data);
    socket.onclose = (event) => this.end(this.why || event.reason || 'the connection was lost');
    this.timer = setInterval(() => this.tick(), POLL);
  }

  /** @param {number} index @param {import('../wire/camera.js').Camera} camera of the traced buffer */
  look(index, camera) {
    this.wanted = { index, camera };
    this.tick();
  }

  /** @param {string} reason */
  close(reason) {
    if (this.socket.readyState === 1) this.socket.send(encodeBye(reason));
    this.end(reason);
  }

  /** @param {string} why */
  end(why) {
    if (this.ended) return;
    this.ended = true;
    clearInterval(this.timer);
    this.carrier.close();
    this.socket.onclose = this.socket.onmessage = null;
    this.socket.close();
    this.stream?.close();
    this.stream = null;
    this.lanes?.close();
    const { refusal, stayOutMs, tooLarge } = this;
    this.emit({ is: 'closed', why, refusal, stayOutMs, tooLarge, opened: this.welcome !== null });
  }

  /** @param {ArrayBuffer | string} data */
  receive(data) {
    try {
      if (typeof data === 'string') throw new Malformed('a message is text');
      this.counters.bytes += data.byteLength;
      const message = decode(new Uint8Array(data));
      if (message) this.on(message);
    } catch (error) {
      if (!(error instanceof Malformed)) throw error;
      this.end(`what the server sent is malformed: ${error.message}`);
    }
  }

  /** @param {{is: string} & Record<string, any>} message */
  on(message) {
    switch (message.is) {
      case 'data':
        return message.slice ? this.onSlice(message.body) : undefined;
      case 'welcome':
        return this.onWelcome(message);
      case 'webTransport':
        return this.carrier.offered(/** @type {any} */ (message));
      case 'refused':
        this.refusal = message;
        this.why = message.text;
        return this.end(message.text);
      case 'bye':
        this.stayOutMs = message.stayOutMs;
        return this.end(message.reason || 'the server said goodbye');
      case 'lightsChanged':
        this.keepLights(message.version, message.lights);
        this.askAgain();
        break;
      case 'degraded':
        this.onDegraded(message);
        break;
      case 'sceneChanged':
        Object.assign(this.welcome, { scene: message.scene, samples: message.samples, areas: message.areas });
        this.lights.clear();
        this.keepLights(0, message.scene.lights);
        this.restart(this.shape.width, this.shape.height, message.samples);
        break;
    }
    this.emit(message);
  }

  /** @param {any} welcome */
  onWelcome(welcome) {
    if (this.welcome) throw new Malformed('a second Welcome');
    this.welcome = welcome;
    this.credit.rateHz = welcome.rateHz;
    this.keepLights(welcome.lightsVersion, welcome.scene.lights);
    if (welcome.codec === Codec.tiles_context) this.lanes = this.makeLanes();
    this.reopen(welcome.width, welcome.height, welcome.samples);
    if (this.ended) return;
    this.emit({ ...welcome, is: 'open' });
    this.tick();
  }

  /**
   * Where the shape of masks stays, what is under way stays good: which lights are traced may change with each camera.
   * @param {{is: string} & Record<string, any>} degraded
   */
  onDegraded({ width, height, rateHz, samples }) {
    this.credit.rateHz = rateHz;
    const inForce = fewest(samples, this.welcome.samples);
    const { shape } = this;
    if (width === shape.width && height === shape.height && inForce === shape.samples) return this.askAgain();
    this.restart(width, height, inForce);
  }

  /**
   * What is under way may be of the shape or scene before: it is dropped, and the newest camera asked for again.
   * @param {number} width @param {number} height @param {number} samples in force
   */
  restart(width, height, samples) {
    this.firstFrame = this.credit.newest + 1;
    this.credit.forget();
    this.reopen(width, height, samples);
    this.askAgain();
  }

  /** The newest camera is to be answered once more: a page at rest asks for nothing by itself. */
  askAgain() {
    this.wanted ??= this.asked;
    this.tick();
  }

  /** @param {number} width @param {number} height @param {number} samples in force (wire/planes.js) */
  reopen(width, height, samples) {
    this.stream?.close();
    this.stream = null;
    this.shape = { width, height, samples };
    this.planes = planesOf(this.welcome.areas, samples);
    const { welcome } = this;
    const granted = { width: welcome.width, height: welcome.height, samples: welcome.samples };
    const shape = { width, height, lights: this.planes.total };
    try {
      this.stream = this.decoder.stream({ ...shape, samples, granted });
    } catch (error) {
      if (!(error instanceof RangeError)) throw error;
      this.tooLarge = true;
      return this.end('these masks are too large for the browser');
    }
    this.lanes?.open(shape);
  }

  /** @param {number} version @param {object[]} lights */
  keepLights(version, lights) {
    this.lights.set(version, lights);
    if (this.lights.size > KEPT_LIGHTS) this.lights.delete(this.lights.keys().next().value);
    this.newestLights = lights;
  }

  /** @param {Uint8Array} body */
  onSlice(body) {
    if (body.length < 4) throw new Malformed('a slice ends too early');
    const number = new DataView(body.buffer, body.byteOffset, 4).getUint32(0, true);
    if (number < this.firstFrame) return;
    const { stream } = this;
    if (!stream) return;
    if (!this.lanes?.isOpen || !stream.isLongWork(body)) return this.take(() => stream.slice(body));
    this.lanes.slice(body.slice(), (words) => {
      if (this.stream === stream) this.take(() => (words ? stream.put(body, words) : stream.slice(body)));
    });
  }

  /** @param {() => import('../decoder.js').Frame | null} decode gives a frame, once it is whole */
  take(decode) {
    let frame;
    try {
      frame = decode();
    } catch {
      this.counters.malformed += 1; // as a datagram that is malformed: it is dropped, and its frame with it
      return;
    }
    if (!frame) return;
    if (this.stream?.have === frame.frame) this.lanes?.keep(frame.frame, frame.words);
    const now = this.now();
    const request = this.credit.whole(frame.frame, now);
    if (!request) return;
    this.counters.frames += 1;
    this.carrier.answered(this.credit.inFlight > 0);
    const responseMs = now - request.sent;
    this.leastResponse = Math.min(this.leastResponse, responseMs);
    this.credit.limit = (this.credit.mean ?? 0) > this.leastResponse + SLOW ? CREDIT_WHEN_SLOW : CREDIT;
    this.emit(
      {
        is: 'frame',
        index: request.index,
        camera: request.camera,
        width: frame.width,
        height: frame.height,
        words: frame.words,
        planes: this.planes,
        sceneTimeUs: frame.sceneTimeUs,
        lightsVersion: frame.lightsVersion,
        lights: this.lights.get(frame.lightsVersion) ?? this.newestLights,
        responseMs,
        serverUs: frame.serverUs,
        gpuUs: frame.gpuUs,
        lanes: this.lanes?.workers.length ?? 0,
        codec: Object.keys(Codec).find((name) => Codec[name] === frame.codec) ?? '?',
        bytes: this.counters.bytes + this.carrier.bytes,
      },
      [frame.words.buffer],
    );
    this.tick();
  }

  /** Of what is under way some went the old way, and may be lost: the newest camera is asked for again. */
  changeWay() {
    this.emit({ is: 'transport', name: this.carrier.name });
    if (!this.asked) return;
    this.credit.forget();
    this.askAgain();
  }

  tick() {
    if (!this.welcome || this.ended || this.socket.readyState !== 1) return;
    this.carrier.tick();
    const now = this.now();
    if (this.wanted && this.credit.isOpen(now)) {
      this.asked = this.wanted;
      this.wanted = null;
      const { index, camera } = this.asked;
      const frame = this.credit.sent(index, camera, now);
      this.newest = { frame, camera, timeUs: 1000 * now, deadlineUs: 0, have: this.stream?.have ?? 0 };
      this.lastSaid = now;
      this.carrier.send(this.newest, true);
    } else if (this.newest && now - this.lastSaid > this.welcome.silenceTimeoutMs / (SIGNS_OF_LIFE + 1)) {
      this.lastSaid = now;
      this.carrier.send({ ...this.newest, have: this.stream?.have ?? 0 }, false);
    }
  }
}
