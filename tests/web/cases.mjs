// Reads what tests/web/decoder_cases.cpp writes.
export class Cases {
  constructor(bytes) {
    this.bytes = bytes;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
    this.at = 0;
  }

  get left() {
    return this.at < this.bytes.length;
  }

  u32() {
    this.at += 4;
    return this.view.getUint32(this.at - 4, true);
  }

  raw(size) {
    const bytes = this.bytes.subarray(this.at, this.at + size);
    this.at += Math.ceil(size / 4) * 4;
    return bytes;
  }
}
