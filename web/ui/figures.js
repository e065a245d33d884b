// The figures of the head-up display, over the last seconds. No clock: times are arguments, in milliseconds.

const SPAN = 2_000;

export class Figures {
  constructor() {
    /** @type {number | null} of the first picture with masks, since the page was opened */
    this.firstMs = null;
    /** @type {{at: number, predicted: boolean}[]} pictures */
    this.pictures = [];
    /** @type {{at: number, responseMs: number, serverUs: number, gpuUs: number, bytes: number}[]} frames of masks */
    this.frames = [];
  }

  /** @param {number} at @param {boolean} predicted */
  picture(at, predicted) {
    this.pictures.push({ at, predicted });
    while (this.pictures[0].at < at - SPAN) this.pictures.shift();
  }

  /**
   * Keeps nothing else of the event, which has whole masks.
   * @param {{at: number, responseMs: number, serverUs: number, gpuUs: number, bytes: number}} frame bytes: of its session, so far
   */
  frame({ at, responseMs, serverUs, gpuUs, bytes }) {
    const last = this.frames[this.frames.length - 1];
    if (last && bytes < last.bytes) this.frames = []; // another session
    this.frames.push({ at, responseMs, serverUs, gpuUs, bytes });
    while (this.frames[0].at < at - SPAN) this.frames.shift();
  }

  /** @param {number} now */
  summary(now) {
    const pictures = this.pictures.filter((each) => each.at >= now - SPAN);
    const frames = this.frames.filter((each) => each.at >= now - SPAN);
    const responses = frames.map((each) => each.responseMs).sort((a, b) => a - b);
    const span = frames.length > 1 ? frames[frames.length - 1].at - frames[0].at : 0;
    const bytes = frames.length > 1 ? frames[frames.length - 1].bytes - frames[0].bytes : 0;
    const last = this.frames[this.frames.length - 1]; // a scene at rest needs no masks; what they took last stays
    return {
      // null while nothing is drawn or sent: a page at rest is not one that stalls
      fps: pictures.length ? pictures.length / (SPAN / 1000) : null,
      masksPerSecond: frames.length ? frames.length / (SPAN / 1000) : null,
      responseMs: responses.length ? responses[responses.length >> 1] : (last?.responseMs ?? null),
      kilobytesPerSecond: span > 0 ? bytes / span : 0,
      predicted: pictures.length ? pictures.filter((each) => each.predicted).length / pictures.length : 0,
      serverMs: last ? last.serverUs / 1000 : null,
      gpuMs: last ? last.gpuUs / 1000 : null,
    };
  }
}
