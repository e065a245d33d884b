// One connection of WebTransport to the daemon, whose datagrams carry what Data messages carry.
//
// A ticket that came over the WebSocket opens it, once. Runs in a worker, as all of the link.

const PATIENCE = 3_000; // milliseconds until it is open
const WAITING = 512; // datagrams that wait for us: a frame comes as a burst

export class Datagrams {
  /**
   * @param {object} parts
   * @param {(url: string, options: object) => any} parts.dial makes a WebTransport
   * @param {string} parts.host of the page, without a port
   * @param {{port: number, ticket: string, hashes: Uint8Array[]}} parts.offer the server's
   * @param {() => void} parts.onOpen
   * @param {(bytes: Uint8Array) => void} parts.onDatagram
   * @param {(served: boolean) => void} parts.onEnd once, unless it was closed from here; whether it had been open
   */
  constructor({ dial, host, offer, onOpen, onDatagram, onEnd }) {
    this.ended = false;
    this.isOpen = false;
    this.onEnd = onEnd;
    this.timer = setTimeout(() => this.end(), PATIENCE);
    const hashes = offer.hashes.map((value) => ({ algorithm: 'sha-256', value: value.slice() }));
    const options = { congestionControl: 'low-latency', ...(hashes.length > 0 && { serverCertificateHashes: hashes }) };
    try {
      this.transport = dial(`https://${host}:${offer.port}/session?ticket=${offer.ticket}`, options);
    } catch {
      queueMicrotask(() => this.end()); // as a policy of the page or of its owner may forbid it
      return;
    }
    this.transport.closed.then(
      () => this.end(),
      () => this.end(),
    );
    this.transport.ready.then(
      () => {
        if (this.ended) return;
        clearTimeout(this.timer);
        const { datagrams } = this.transport;
        datagrams.incomingHighWaterMark = WAITING;
        this.writer = (datagrams.createWritable?.() ?? datagrams.writable).getWriter();
        this.isOpen = true;
        onOpen();
        this.read(datagrams.readable.getReader(), onDatagram);
      },
      () => this.end(),
    );
  }

  /** @param {ReadableStreamDefaultReader<Uint8Array>} reader @param {(bytes: Uint8Array) => void} onDatagram */
  async read(reader, onDatagram) {
    try {
      for (;;) {
        const { value, done } = await reader.read();
        if (done || this.ended) break;
        onDatagram(/** @type {Uint8Array} */ (value));
      }
    } catch {
      // The connection is gone, which ends it below.
    }
    this.end();
  }

  /** One that finds no room is lost, as on the way. @param {Uint8Array} bytes */
  send(bytes) {
    this.writer?.write(bytes.slice()).catch(() => {});
  }

  end() {
    if (this.ended) return;
    const served = this.isOpen;
    this.close();
    this.onEnd(served);
  }

  close() {
    this.ended = true;
    this.isOpen = false;
    clearTimeout(this.timer);
    try {
      this.transport?.close();
    } catch {
      // It was not open yet, and is not wanted any more.
    }
  }
}
