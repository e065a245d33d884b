// Workers beside that of the session, which decode its slices of tiles_context: with eight lights these take one worker
// longer than a frame may. Slices go to them in turn; each has all references. What they cannot decode is given back.

const MOST = 4;
const OTHERS = 2; // the page's thread and this worker

/** How many are worth it with so many processors. @param {number} processors */
export const lanesFor = (processors) => (processors - OTHERS < 2 ? 0 : Math.min(MOST, Math.floor(processors - OTHERS)));

/** @typedef {(words: Uint32Array | null) => void} Done null: not decoded */

export class Lanes {
  /**
   * @param {object} parts
   * @param {number} parts.count
   * @param {() => Worker} parts.spawn of lane.js
   * @param {WebAssembly.Module} parts.module the decoder
   */
  constructor({ count, spawn, module }) {
    /** @type {Map<number, Done>} slices that are being decoded */
    this.waiting = new Map();
    this.next = 0;
    this.workers = Array.from({ length: count }, spawn);
    for (const worker of this.workers) {
      worker.onmessage = ({ data }) => this.on(data.id, data.words);
      worker.onerror = () => this.close();
      worker.postMessage({ do: 'load', module });
    }
  }

  /** Slices are of another mask from now on; those under way are forgotten. @param {object} shape */
  open(shape) {
    this.waiting.clear();
    for (const worker of this.workers) worker.postMessage({ do: 'open', shape });
  }

  /** @param {Uint8Array} body @param {Done} done is called later */
  slice(body, done) {
    const id = this.next++;
    this.waiting.set(id, done);
    this.workers[id % this.workers.length].postMessage({ do: 'slice', id, body });
  }

  /** @param {number} frame @param {Uint32Array} words */
  keep(frame, words) {
    for (const worker of this.workers) worker.postMessage({ do: 'keep', frame, words });
  }

  /** @private @param {number} id @param {Uint32Array | null} words */
  on(id, words) {
    const done = this.waiting.get(id);
    this.waiting.delete(id);
    done?.(words);
  }

  get isOpen() {
    return this.workers.length > 0;
  }

  /** Ends them. What they had is not decoded. */
  close() {
    for (const worker of this.workers) worker.terminate();
    this.workers = [];
    for (const id of [...this.waiting.keys()]) this.on(id, null);
  }
}
