// Timers in virtual time: those of node:test are called differently by each of its versions.

const REAL = { setInterval, clearInterval, setTimeout, clearTimeout };

export class Timers {
  constructor() {
    this.now = 0;
    this.pending = [];
    const after = (/** @type {any} */ call, /** @type {number} */ ms, /** @type {number} */ again) => {
      const timer = { call, at: this.now + ms, again };
      this.pending.push(timer);
      return timer;
    };
    const forget = (/** @type {any} */ timer) => {
      this.pending = this.pending.filter((each) => each !== timer);
    };
    Object.assign(globalThis, {
      setInterval: (/** @type {any} */ call, /** @type {number} */ ms) => after(call, ms, ms),
      setTimeout: (/** @type {any} */ call, /** @type {number} */ ms) => after(call, ms, 0),
      clearInterval: forget,
      clearTimeout: forget,
    });
  }

  pass(/** @type {number} */ ms) {
    this.now += ms;
    for (const timer of [...this.pending]) {
      if (timer.at > this.now || !this.pending.includes(timer)) continue;
      if (timer.again > 0) timer.at = this.now + timer.again;
      else clearTimeout(timer);
      timer.call();
    }
  }

  restore() {
    Object.assign(globalThis, REAL);
  }
}
