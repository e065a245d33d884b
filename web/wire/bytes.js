// Little-endian fields, as protocol/WIRE.md writes them. A reader throws Malformed where bytes are missing or a value is
// one that the document forbids, so that whoever reads a message acts on all of it or on nothing.

/** What was read breaks the wire protocol. */
export class Malformed extends Error {}

const decoder = new TextDecoder('utf-8', { fatal: true });
const encoder = new TextEncoder();

export class Reader {
  /** @param {Uint8Array} bytes */
  constructor(bytes) {
    this.bytes = bytes;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    this.at = 0;
  }

  /** Bytes that are left. */
  get left() {
    return this.bytes.length - this.at;
  }

  /** The place of the next `count` bytes, which are then behind the reader. @param {number} count */
  take(count) {
    if (this.left < count) throw new Malformed('a message ends too early');
    const place = this.at;
    this.at += count;
    return place;
  }

  u8() {
    return this.view.getUint8(this.take(1));
  }
  u16() {
    return this.view.getUint16(this.take(2), true);
  }
  u32() {
    return this.view.getUint32(this.take(4), true);
  }
  u64() {
    return this.view.getBigUint64(this.take(8), true);
  }

  f32() {
    const value = this.view.getFloat32(this.take(4), true);
    if (!Number.isFinite(value)) throw new Malformed('a number is not finite');
    return value;
  }

  /** A rate, a size or a strength, none of which is below 0. */
  rate() {
    const value = this.f32();
    if (value < 0) throw new Malformed('a rate is negative');
    return value;
  }

  /** @param {number} count @returns {number[]} */
  floats(count) {
    return Array.from({ length: count }, () => this.f32());
  }

  /** @param {number} most bytes */
  text(most) {
    const size = this.u16();
    if (size > most) throw new Malformed('a text is too long');
    const place = this.take(size);
    let text;
    try {
      text = decoder.decode(this.bytes.subarray(place, place + size));
    } catch {
      throw new Malformed('a text is not UTF-8');
    }
    // eslint-disable-next-line no-control-regex
    if (/[\u0000-\u001f\u007f-\u009f]/.test(text)) throw new Malformed('a text has control characters');
    return text;
  }

  /** @template T @param {number} most items @param {() => T} item @returns {T[]} */
  list(most, item) {
    const count = this.u16();
    if (count > most) throw new Malformed('a list is too long');
    return Array.from({ length: count }, item);
  }

  /** The next bytes, not copied. @param {number} count */
  raw(count) {
    const place = this.take(count);
    return this.bytes.subarray(place, place + count);
  }
}

export class Writer {
  constructor() {
    this.bytes = new Uint8Array(256);
    this.view = new DataView(this.bytes.buffer);
    this.size = 0;
  }

  /** The place of `count` new bytes. @param {number} count */
  room(count) {
    const place = this.size;
    this.size += count;
    if (this.size > this.bytes.length) {
      const larger = new Uint8Array(Math.max(this.size, 2 * this.bytes.length));
      larger.set(this.bytes);
      this.bytes = larger;
      this.view = new DataView(larger.buffer);
    }
    return place;
  }

  /** @param {string} set a setter of DataView @param {number} size @param {number | bigint} value */
  put(set, size, value) {
    const place = this.room(size); // this may replace the view
    this.view[set](place, value, true);
  }

  /** @param {number} value */
  u8(value) {
    this.put('setUint8', 1, value);
  }
  /** @param {number} value */
  u16(value) {
    this.put('setUint16', 2, value);
  }
  /** @param {number} value */
  u32(value) {
    this.put('setUint32', 4, value);
  }
  /** @param {bigint} value */
  u64(value) {
    this.put('setBigUint64', 8, value);
  }
  /** @param {number} value */
  f32(value) {
    this.put('setFloat32', 4, value);
  }
  /** @param {ArrayLike<number>} values */
  floats(values) {
    for (let i = 0; i < values.length; ++i) this.f32(values[i]);
  }

  /** @param {string} value @param {number} most bytes */
  text(value, most) {
    const bytes = encoder.encode(value);
    if (bytes.length > most) throw new RangeError(`a text of ${bytes.length} bytes, where ${most} fit`);
    this.u16(bytes.length);
    this.raw(bytes);
  }

  /** @param {Uint8Array} bytes */
  raw(bytes) {
    const place = this.room(bytes.length);
    this.bytes.set(bytes, place);
  }

  /** What was written, not copied. */
  done() {
    return this.bytes.subarray(0, this.size);
  }
}
