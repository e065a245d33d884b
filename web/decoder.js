// Frames' masks out of slices: the native client's own C++, compiled to WebAssembly (web/wasm). For workers, pages and
// node. One thread.
//
// Whatever the slices hold, there is a frame, none yet, or a DecodeError; a slice that is malformed counts as lost.

/** A slice that is no slice, or does not decode. */
export class DecodeError extends Error {
  /** @param {string} message */
  constructor(message) {
    super(message);
    this.name = 'DecodeError';
  }
}

/**
 * A frame of which every slice has come.
 * @typedef {object} Frame
 * @property {number} frame
 * @property {number} width
 * @property {number} height
 * @property {number} lights
 * @property {Uint32Array} words two for each tile of each light, the low one first: those of tile t of light l are
 *   2 * (l * tiles + t) and the one behind it
 * @property {number} sceneTimeUs
 * @property {number} lightsVersion
 * @property {number} serverUs
 * @property {number} gpuUs
 * @property {number} bytes of all payloads
 * @property {number} codec of the slice that came last, as WIRE.md numbers them
 */

/**
 * What the module exports; addresses are numbers.
 * @typedef {object} Exports
 * @property {WebAssembly.Memory} memory
 * @property {() => void} _initialize
 * @property {() => number} body
 * @property {() => number} most_bytes
 * @property {(width: number, height: number, planes: number, samples: number, grantedWidth: number,
 *   grantedHeight: number, grantedSamples: number) => number} open
 * @property {(stream: number) => void} close
 * @property {(stream: number, bytes: number) => number} slice
 * @property {(stream: number) => number} taken
 * @property {(stream: number) => number} have
 * @property {(stream: number, bytes: number) => number} is_long_work
 * @property {(stream: number, words: number) => number} decoded_place
 * @property {(stream: number, bytes: number) => number} decoded_slice
 * @property {(width: number, height: number, lights: number) => number} open_lane
 * @property {(lane: number) => void} close_lane
 * @property {(lane: number, bytes: number) => number} lane_slice
 * @property {(lane: number) => number} lane_words
 * @property {(lane: number) => number} lane_mask
 * @property {(lane: number, frame: number) => void} lane_keep
 */

const kWhole = 1; // answers of slice(), as web/wasm/decoder.cpp has them
const kMalformed = 2;

export class Decoder {
  /**
   * @param {WebAssembly.Module | BufferSource} source of decoder.wasm
   * @returns {Promise<Decoder>}
   */
  static async load(source) {
    const module = source instanceof WebAssembly.Module ? source : await WebAssembly.compile(source);
    const instance = await WebAssembly.instantiate(module, {});
    return new Decoder(/** @type {any} */ (instance.exports), module);
  }

  /**
   * Use load().
   * @param {Exports} exports
   * @param {WebAssembly.Module} module for other workers, which need not compile it again
   */
  constructor(exports, module) {
    this.exports = exports;
    this.module = module;
    exports._initialize();
  }

  /**
   * Masks of one size and number of lights, or of planes where these have several (wire/planes.js); another stream is
   * opened when these change, which forgets the frames kept. `samples` (wire/planes.js) are in force. `granted` is what
   * Welcome says, which slices have that say nothing; by default the stream's own. Throws a RangeError if a mask of that
   * size is none, or larger than there is memory for.
   * @param {{width: number, height: number, lights: number, samples?: number,
   *   granted?: {width: number, height: number, samples?: number}}} shape
   */
  stream({ width, height, lights, samples = 1, granted = { width, height, samples } }) {
    const { open } = this.exports;
    const handle = open(width, height, lights, samples, granted.width, granted.height, granted.samples ?? samples);
    if (handle === 0)
      throw new RangeError(`no mask of ${width} x ${height} pixels and ${lights} lights can be decoded`);
    return new MaskStream(this.exports, handle, { width, height, lights });
  }
}

/** Puts a slice's body where the module reads it. @param {Exports} exports @param {Uint8Array} body */
function give(exports, body) {
  if (body.length > exports.most_bytes()) throw new DecodeError('a slice is longer than any may be');
  new Uint8Array(exports.memory.buffer, exports.body(), body.length).set(body);
}

/** Decodes slices of a stream elsewhere, with the same references: see link/lanes.js. */
export class Lane {
  /** @param {Decoder} decoder @param {{width: number, height: number, lights: number}} shape of the stream */
  constructor({ exports }, { width, height, lights }) {
    this.exports = exports;
    this.handle = exports.open_lane(width, height, lights);
    if (this.handle === 0) throw new RangeError('no mask of that size can be decoded');
  }

  /** Its words, light by light; null: it cannot be decoded here. @param {Uint8Array} body */
  slice(body) {
    const { exports, handle } = this;
    give(exports, body);
    const count = exports.lane_slice(handle, body.length);
    if (count === 0) return null;
    return new Uint32Array(exports.memory.buffer, exports.lane_words(handle), 2 * count).slice();
  }

  /** Slices may refer to this frame from now on. @param {number} frame @param {Uint32Array} words */
  keep(frame, words) {
    const { exports, handle } = this;
    new Uint32Array(exports.memory.buffer, exports.lane_mask(handle), words.length).set(words);
    exports.lane_keep(handle, frame);
  }

  close() {
    this.exports.close_lane(this.handle);
  }
}

export class MaskStream {
  /**
   * Use Decoder.stream().
   * @param {Exports} exports
   * @param {number} handle
   * @param {{width: number, height: number, lights: number}} shape
   */
  constructor(exports, handle, shape) {
    this.exports = exports;
    this.handle = handle;
    this.shape = shape;
  }

  /**
   * @param {Uint8Array} body of a FrameSlice
   * @returns {Frame | null} null unless it was the last slice that its frame lacked
   */
  slice(body) {
    give(this.exports, body);
    return this.answer(this.exports.slice(this.handle, body.length));
  }

  /** Whether a lane should decode this slice, so that put() takes it. @param {Uint8Array} body */
  isLongWork(body) {
    if (body.length > this.exports.most_bytes()) return false;
    give(this.exports, body);
    return this.exports.is_long_work(this.handle, body.length) !== 0;
  }

  /** As slice(), of a slice that a lane has decoded. @param {Uint8Array} body @param {Uint32Array} words */
  put(body, words) {
    const { exports, handle } = this;
    const place = exports.decoded_place(handle, words.length / 2);
    new Uint32Array(exports.memory.buffer, place, words.length).set(words);
    give(exports, body);
    return this.answer(exports.decoded_slice(handle, body.length));
  }

  /** @private @param {number} answer */
  answer(answer) {
    if (answer === kMalformed) throw new DecodeError('a slice is malformed');
    return answer === kWhole ? this.frame() : null;
  }

  /**
   * What was taken last.
   * @returns {Frame}
   */
  frame() {
    const { buffer } = this.exports.memory;
    const [frame, words, count, sceneTimeUs, lightsVersion, serverUs, gpuUs, bytes, codec] = new Uint32Array(
      buffer,
      this.exports.taken(this.handle),
      9,
    );
    return {
      frame,
      ...this.shape,
      words: new Uint32Array(buffer, words, 2 * count).slice(),
      sceneTimeUs,
      lightsVersion,
      serverUs,
      gpuUs,
      bytes,
      codec,
    };
  }

  /** The newest frame that is kept for others to refer to: `have` of camera updates (WIRE.md). 0: none. */
  get have() {
    return this.handle === 0 ? 0 : this.exports.have(this.handle) >>> 0;
  }

  /** Frees the memory; the stream is of no use any more. */
  close() {
    if (this.handle !== 0) this.exports.close(this.handle);
    this.handle = 0;
  }
}
