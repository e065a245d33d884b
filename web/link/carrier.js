// How cameras leave a session and slices come to it: over its WebSocket, and, where the server offers it and the network
// lets it pass, as datagrams by WebTransport. What changes from one to the other costs the frames that are under way.
import { cameraDatagram, cameraMessage, decodeDatagram } from '../wire/messages.js';
import { Datagrams } from './datagrams.js';
import { Way } from './way.js';

export class Carrier {
  /**
   * @param {object} parts
   * @param {WebSocket} parts.socket
   * @param {((url: string, options: object) => any) | null} parts.dial makes a WebTransport; null: there is none
   * @param {(body: Uint8Array) => void} parts.onSlice
   * @param {() => void} parts.onChange the way is another one
   * @param {() => number} parts.now milliseconds
   */
  constructor({ socket, dial, onSlice, onChange, now }) {
    this.socket = socket;
    this.dial = dial;
    this.onSlice = onSlice;
    this.onChange = onChange;
    this.now = now;
    this.way = new Way();
    /** @type {{port: number, ticket: string, hashes: Uint8Array[]} | null} */
    this.offer = null;
    /** @type {Datagrams | null} */
    this.datagrams = null;
    this.bytes = 0; // of datagrams that arrived
  }

  /** As people read it. */
  get name() {
    return this.datagrams?.isOpen ? 'WebTransport' : 'WebSocket';
  }

  /** @param {{port: number, ticket: string, hashes: Uint8Array[]}} offer */
  offered(offer) {
    this.offer = offer;
    this.tick();
  }

  /** @param {import('../wire/messages.js').CameraUpdate} update @param {boolean} asks it is to be answered */
  send(update, asks) {
    if (asks) this.way.asked(this.now());
    if (this.datagrams?.isOpen) this.datagrams.send(cameraDatagram(update));
    else this.socket.send(cameraMessage(update));
  }

  /** A frame is whole. @param {boolean} more others are under way */
  answered(more) {
    this.way.answered(more, this.now());
  }

  tick() {
    const now = this.now();
    if (this.datagrams) {
      const why = this.datagrams.isOpen && this.way.complaint(now);
      if (why) this.leave(why, true);
      return;
    }
    if (!this.dial || !this.offer || !this.way.mayTry(now)) return;
    const tried = new Datagrams({
      dial: this.dial,
      host: new URL(this.socket.url).hostname,
      offer: this.offer,
      onOpen: () => {
        this.way.enter(this.now());
        this.onChange();
      },
      onDatagram: (bytes) => this.receive(bytes),
      onEnd: (served) => this.leave('end', served),
    });
    this.datagrams = tried;
  }

  /** @param {Uint8Array} bytes */
  receive(bytes) {
    this.bytes += bytes.length;
    const datagram = decodeDatagram(bytes);
    if (!datagram) return; // as a datagram that is malformed: it is dropped
    this.way.received(datagram.sequence, this.now());
    if (datagram.slice) this.onSlice(datagram.body);
  }

  /** @param {string} why @param {boolean} served it was the way */
  leave(why, served) {
    this.datagrams?.close();
    this.datagrams = null;
    this.way.leave(why, this.now());
    if (served) this.onChange();
  }

  close() {
    this.datagrams?.close();
    this.datagrams = null;
    this.dial = null;
  }
}
