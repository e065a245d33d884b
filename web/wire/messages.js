// The control messages of protocol/WIRE.md that a client in a browser sends and receives.
//
// Over a WebSocket each binary message is one control message, its length included.
import { Malformed, Reader, Writer } from './bytes.js';
import { readCamera, writeCamera } from './camera.js';
import { areSamples } from './planes.js';

export const VERSION = 2;

/** Bits of Hello.features. */
export const Feature = {
  moments: 1n,
  references: 2048n,
  sizes: 32n,
  paths: 64n,
  waiting: 128n,
  webTransport: 256n,
  fleet: 512n,
  soft: 1024n,
};

// The server demands `paths` of every client by default. A browser has no datagrams, hence no address to prove.
const FEATURES =
  Feature.moments | Feature.references | Feature.sizes | Feature.paths | Feature.waiting | Feature.fleet;

export const Type = {
  hello: 1,
  welcome: 2,
  refused: 3,
  sceneChanged: 4,
  lightsChanged: 5,
  degraded: 6,
  draining: 7,
  stats: 8,
  bye: 9,
  data: 10,
  waiting: 12,
  webTransport: 13,
};
const NO_DEADLINE = 0xffffffff; // of draining
const MOVE_NOW = 1; // its flag
const Kind = { cameraUpdate: 1, frameSlice: 2 };

/** Codec numbers by the names that the server's log gives them. */
export const Codec = { raw32_lz4: 0, tiles_lz4: 1, tiles_context: 3 };

/** The code of Refused that an operator's kick leads to; nobody comes back by itself then. */
export const KEPT_OUT = 14;

/** @param {number} type @param {(out: Writer) => void} body @returns {Uint8Array} */
function message(type, body) {
  const out = new Writer();
  out.u32(0);
  out.u16(type);
  body(out);
  out.view.setUint32(0, out.size - 4, true);
  return out.done();
}

/**
 * @typedef {object} Hello
 * @property {string} client program and version
 * @property {string} tenant empty: the server's default
 * @property {string} token empty where none is needed
 * @property {string} scene
 * @property {number} width of the traced buffer, border included
 * @property {number} height
 * @property {number} borderX
 * @property {number} borderY
 * @property {number} rateHz 0: as many as it gets
 * @property {number[]} codecs in order of preference
 * @property {boolean} [webTransport] whether this browser has it
 * @property {number} [samples] what is wanted counted (planes.js)
 */

/** @param {Hello} hello */
export function encodeHello(hello) {
  const samples = hello.samples ?? 1;
  const soft = samples > 1 ? Feature.soft : 0n;
  return message(Type.hello, (out) => {
    out.u16(VERSION);
    out.u16(VERSION);
    out.u64(FEATURES | soft | (hello.webTransport ? Feature.webTransport : 0n));
    out.text(hello.client, 256);
    out.text(hello.tenant, 256);
    out.text(hello.token, 512);
    out.u16(1);
    out.u8(1); // a cipher has to be named, though nothing is sealed inside TLS
    out.text(hello.scene, 1024);
    for (const size of [hello.width, hello.height, hello.borderX, hello.borderY]) out.u16(size);
    out.f32(hello.rateHz);
    out.u16(hello.codecs.length);
    hello.codecs.forEach((codec) => out.u8(codec));
    out.u16(0); // passes: the server's own
    if (soft) out.u8(samples);
  });
}

/** @param {string} reason */
export function encodeBye(reason) {
  return message(Type.bye, (out) => {
    out.text(reason, 1024);
    out.u32(0);
  });
}

/** @typedef {{frame: number, camera: import('./camera.js').Camera, timeUs: number, deadlineUs: number, have: number}} CameraUpdate */

/** @param {CameraUpdate} update */
function cameraBody(update) {
  const body = new Writer();
  body.u32(update.frame);
  writeCamera(body, update.camera);
  body.u64(BigInt(Math.max(0, Math.round(update.timeUs))));
  body.u32(update.deadlineUs);
  body.u8(0); // acknowledgements are for those who lose datagrams
  body.u32(update.have);
  return body.done();
}

/** A camera update as a message. @param {CameraUpdate} update */
export function cameraMessage(update) {
  const body = cameraBody(update);
  return message(Type.data, (out) => {
    out.u8(Kind.cameraUpdate);
    out.u64(0n);
    out.u16(body.length);
    out.raw(body);
  });
}

/** The same as a datagram of WebTransport. @param {CameraUpdate} update */
export function cameraDatagram(update) {
  const out = new Writer();
  out.u8(Kind.cameraUpdate);
  out.u64(0n);
  out.raw(cameraBody(update));
  return out.done();
}

/** A datagram of the server; null if it is malformed. `body` lies in `bytes`. @param {Uint8Array} bytes */
export function decodeDatagram(bytes) {
  const from = new Reader(bytes);
  if (from.left < 9) return null;
  const kind = from.u8();
  const sequence = from.u64();
  return { slice: kind === Kind.frameSlice, sequence, body: from.raw(from.left) };
}

/** @param {Reader} from */
function readLight(from) {
  const kind = from.u8();
  const [position, direction, color] = [from.floats(3), from.floats(3), from.floats(3)];
  const [intensity, range] = [from.rate(), from.rate()];
  const [innerConeCos, outerConeCos] = from.floats(2);
  if (kind > 2 || (kind !== 0 && Math.abs(Math.hypot(...direction) - 1) > 0.001))
    throw new Malformed('a light is none');
  if (Math.abs(innerConeCos) > 1 || Math.abs(outerConeCos) > 1) throw new Malformed('a cone has no cosine');
  return { kind, position, direction, color, intensity, range, innerConeCos, outerConeCos };
}

/** @param {Reader} from */
function readSamples(from) {
  const samples = from.u8();
  if (!areSamples(samples)) throw new Malformed('a number of samples is none');
  return samples;
}

/** Which lights have an extent. What it is like is the server's affair. @param {Reader} from @param {number} lights */
function readAreas(from, lights) {
  const areas = from.list(256, () => {
    const shape = from.u8();
    from.floats(3);
    from.floats(3);
    if (shape > 3) throw new Malformed('an extent is none');
    return shape !== 0;
  });
  if (areas.length !== lights) throw new Malformed('there are not as many extents as lights');
  return areas;
}

/** @param {Reader} from */
function readManifest(from) {
  const name = from.text(1024);
  const contentHash = Array.from(from.raw(16), (byte) => byte.toString(16).padStart(2, '0')).join('');
  const triangles = Number(from.u64());
  const [boundsMin, boundsMax] = [from.floats(3), from.floats(3)];
  const defaultCamera = readCamera(from);
  const lights = from.list(256, () => readLight(from));
  return { name, contentHash, triangles, boundsMin, boundsMax, defaultCamera, lights };
}

/** @param {Reader} from */
function readMotion(from) {
  const node = from.text(256);
  const kind = from.u8();
  const vector = from.floats(3);
  const periodUs = from.u32();
  if (kind > 1 || periodUs === 0) throw new Malformed('a motion is none');
  return { node, kind: kind === 0 ? 'spin' : 'shift', vector, periodUs };
}

/** @param {Reader} from */
function readSize(from) {
  const size = { width: from.u16(), height: from.u16() };
  if (size.width < 1 || size.width > 7680 || size.height < 1 || size.height > 7680) {
    throw new Malformed('a size is none');
  }
  return size;
}

/** @param {Reader} from */
function readWelcome(from) {
  const version = from.u16();
  const features = from.u64();
  const session = from.u64().toString(16).padStart(16, '0');
  from.u16(); // the port for datagrams
  from.u8(); // and their cipher
  const size = readSize(from);
  const rateHz = from.rate();
  const codec = from.u8();
  const passes = from.list(32, () => from.text(256));
  const tracer = from.text(256);
  const silenceTimeoutMs = from.u32();
  const scene = readManifest(from);
  const moments = (features & Feature.moments) !== 0n;
  const lightsVersion = moments ? from.u32() : 0;
  const motions = moments ? from.list(256, () => readMotion(from)) : [];
  if ((features & Feature.fleet) !== 0n) {
    from.text(256); // where datagrams go,
    from.text(256); // and where the session is resumed:
    from.u16(); // a page does neither
  }
  const soft = (features & Feature.soft) !== 0n;
  const samples = soft ? readSamples(from) : 1;
  const areas = soft ? readAreas(from, scene.lights.length) : scene.lights.map(() => false);
  return {
    version,
    session,
    ...size,
    rateHz,
    codec,
    passes,
    tracer,
    silenceTimeoutMs,
    scene,
    lightsVersion,
    motions,
    samples,
    areas,
  };
}

/** What a session without the feature soft is not told of is left out. @param {Reader} from */
function readSceneChanged(from) {
  const scene = readManifest(from);
  const soft = from.left > 0;
  return {
    scene,
    samples: soft ? readSamples(from) : 1,
    areas: soft ? readAreas(from, scene.lights.length) : scene.lights.map(() => false),
  };
}

/** @type {Record<number, [string, (from: Reader) => object]>} */
const READERS = {
  [Type.welcome]: ['welcome', readWelcome],
  [Type.refused]: [
    'refused',
    (from) => ({
      code: from.u16(),
      text: from.text(1024),
      fitWidth: from.u16(),
      fitHeight: from.u16(),
      fitRateHz: from.rate(),
    }),
  ],
  [Type.sceneChanged]: ['sceneChanged', readSceneChanged],
  [Type.lightsChanged]: [
    'lightsChanged',
    (from) => ({
      lights: from.list(256, () => readLight(from)),
      version: from.u32(),
    }),
  ],
  [Type.degraded]: [
    'degraded',
    (from) => ({
      ...readSize(from),
      rateHz: from.rate(),
      reason: from.text(1024),
      untraced: from.list(256, () => from.u16()),
      samples: from.left > 0 ? readSamples(from) : 1,
    }),
  ],
  [Type.draining]: [
    'draining',
    (from) => {
      const deadlineMs = from.u32();
      const flags = from.left >= 1 ? from.u8() : 0;
      return { deadlineMs: deadlineMs === NO_DEADLINE ? Infinity : deadlineMs, moveNow: (flags & MOVE_NOW) !== 0 };
    },
  ],
  [Type.stats]: [
    'stats',
    (from) => ({
      frames: Number(from.u64()),
      coalesced: Number(from.u64()),
      queueUs: from.u32(),
      gpuUs: from.u32(),
      totalUs: from.u32(),
    }),
  ],
  [Type.bye]: ['bye', (from) => ({ reason: from.text(1024), stayOutMs: from.left >= 4 ? from.u32() : 0 })],
  [Type.waiting]: ['waiting', (from) => ({ text: from.text(1024), percent: readPercent(from) })],
  [Type.webTransport]: [
    'webTransport',
    (from) => ({ port: from.u16(), ticket: from.text(64), hashes: from.list(4, () => from.raw(32)) }),
  ],
  [Type.data]: [
    'data',
    (from) => {
      const kind = from.u8();
      from.u64();
      const size = from.u16();
      return { slice: kind === Kind.frameSlice, body: from.raw(size) };
    },
  ],
};

/** Null: not known. @param {Reader} from */
function readPercent(from) {
  const percent = from.u8();
  if (percent > 100 && percent !== 255) throw new Malformed('a percentage is none');
  return percent === 255 ? null : percent;
}

/**
 * One message of the server; null if its type is unknown, which is to be skipped. `data.body` lies in `bytes`.
 * @param {Uint8Array} bytes
 * @returns {({is: string} & Record<string, any>) | null}
 */
export function decode(bytes) {
  const from = new Reader(bytes);
  if (from.u32() !== bytes.length - 4) throw new Malformed('a message has another length than it says');
  const known = READERS[from.u16()];
  if (!known) return null;
  const [is, read] = known;
  return { is, ...read(from) };
}
