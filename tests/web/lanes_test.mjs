// Workers that decode beside that of the session, with workers that are none.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Lanes, lanesFor } from '../../web/link/lanes.js';
import { Session } from '../../web/link/session.js';
import { Codec } from '../../web/wire/messages.js';
import { Timers } from './timers.mjs';

class FakeWorker {
  constructor() {
    this.told = [];
    this.ended = false;
  }
  postMessage(message) {
    this.told.push(message);
  }
  terminate() {
    this.ended = true;
  }
  /** Answers a slice: its words say which worker it was. */
  answer(id, words = new Uint32Array([id])) {
    this.onmessage({ data: { id, words } });
  }
  told_of(what) {
    return this.told.filter((message) => message.do === what);
  }
}

function lanesOf(count) {
  const workers = [];
  const spawn = () => workers[workers.push(new FakeWorker()) - 1];
  return { workers, lanes: new Lanes({ count, spawn, module: 'module' }) };
}

test('two processors are for the page and its session', () => {
  assert.deepEqual([1, 2, 3, 4, 5, 8, 64].map(lanesFor), [0, 0, 0, 2, 3, 4, 4]);
});

test('slices go in turn, answers come in any order, and all know every reference', () => {
  const { workers, lanes } = lanesOf(2);
  const done = [];
  lanes.open({ width: 8 });
  for (const name of ['a', 'b', 'c']) lanes.slice(new Uint8Array([1]), (words) => done.push([name, words?.[0]]));
  lanes.keep(7, new Uint32Array(2));
  assert.deepEqual(
    workers.map((worker) => worker.told.map((message) => message.do)),
    [
      ['load', 'open', 'slice', 'slice', 'keep'],
      ['load', 'open', 'slice', 'keep'],
    ],
  );
  workers[1].answer(1);
  workers[0].answer(2);
  workers[0].answer(0);
  workers[0].answer(0); // once only
  assert.deepEqual(done, [
    ['b', 1],
    ['c', 2],
    ['a', 0],
  ]);
});

test('masks of another size make what is under way void; a worker that fails gives all back', () => {
  const { workers, lanes } = lanesOf(2);
  const done = [];
  lanes.slice(new Uint8Array([1]), () => done.push('before'));
  lanes.open({ width: 16 });
  workers[0].answer(0);
  lanes.slice(new Uint8Array([1]), (words) => done.push(words));
  workers[0].onerror();
  assert.deepEqual(done, [null]);
  assert.ok(!lanes.isOpen && workers.every((worker) => worker.ended));
});

/** A decoder of frames of two slices, each of which is long work. Says by which way each came. */
function decoder(log) {
  return {
    stream: () => {
      const got = new Map();
      const take = (frame) => {
        got.set(frame, (got.get(frame) ?? 0) + 1);
        if (got.get(frame) < 2) return null;
        stream.have = frame;
        return { frame, words: new Uint32Array(2), width: 8, height: 8, lightsVersion: 0, codec: Codec.tiles_context };
      };
      const stream = {
        have: 0,
        isLongWork: () => true,
        slice: (body) => (log.push('here'), take(body[0])),
        put: (body, words) => (log.push(`lane ${words[0]}`), take(body[0])),
        close() {},
      };
      return stream;
    },
  };
}

function sessionOf(t, codec) {
  const timers = new Timers();
  t.after(() => timers.restore());
  const { workers, lanes } = lanesOf(2);
  const log = [];
  const events = [];
  const socket = { readyState: 1, send() {}, close() {} };
  const session = new Session({
    socket,
    decoder: decoder(log),
    lanes: () => lanes,
    hello: /** @type {any} */ ({}),
    emit: (event) => events.push(event),
    now: () => 0,
  });
  session.look(0, /** @type {any} */ ({ position: [0, 0, 0], orientation: [0, 0, 0, 1] }));
  const scene = { lights: [{}] };
  const soft = { samples: 1, areas: [false] };
  session.onWelcome({ codec, rateHz: 0, lightsVersion: 0, scene, ...soft, width: 8, height: 8, silenceTimeoutMs: 4000 });
  const frames = () => events.filter((event) => event.is === 'frame').length;
  return { session, workers, log, frames };
}

const slice = (frame) => new Uint8Array([frame, 0, 0, 0, 0]);

test('a frame is whole when the last of its slices has come back', (t) => {
  const { session, workers, log, frames } = sessionOf(t, Codec.tiles_context);
  session.onSlice(slice(1));
  session.onSlice(slice(1));
  assert.deepEqual([log, frames()], [[], 0]);
  workers[1].answer(1);
  workers[0].answer(0, null); // it could not: the session does it
  assert.deepEqual(log, ['lane 1', 'here']);
  assert.equal(frames(), 1);
  assert.deepEqual(
    workers.map((worker) => worker.told_of('keep').map((message) => message.frame)),
    [[1], [1]],
  );
});

test('what comes back to another mask, or after the end, is dropped', (t) => {
  const { session, workers, log, frames } = sessionOf(t, Codec.tiles_context);
  session.onSlice(slice(1));
  session.reopen(16, 16, 1);
  workers[0].answer(0);
  session.onSlice(slice(1));
  session.close('over');
  assert.deepEqual([log, frames()], [[], 0]);
  assert.ok(workers.every((worker) => worker.ended));
});

test('another code is decoded by the session alone', (t) => {
  const { session, workers, log, frames } = sessionOf(t, Codec.tiles_lz4);
  session.onSlice(slice(1));
  session.onSlice(slice(1));
  assert.deepEqual([log, frames()], [['here', 'here'], 1]);
  assert.deepEqual(workers.map((worker) => worker.told_of('slice').length), [0, 0]);
});
