// Which way cameras and slices go, with a WebTransport that is none, in virtual time.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Carrier } from '../../web/link/carrier.js';
import { Way } from '../../web/link/way.js';
import { Timers } from './timers.mjs';
import { Writer } from '../../web/wire/bytes.js';

const update = {
  frame: 1,
  timeUs: 0,
  deadlineUs: 0,
  have: 0,
  camera: {
    position: [0, 0, 0],
    orientation: [0, 0, 0, 1],
    tanLeft: 1,
    tanRight: 1,
    tanUp: 1,
    tanDown: 1,
    near: 0.0625,
  },
};
const offer = { port: 7601, ticket: 'abc', hashes: [new Uint8Array(32)] };

/** A slice as a datagram of the server. */
function slice(sequence) {
  const out = new Writer();
  out.u8(2);
  out.u64(BigInt(sequence));
  out.raw(new Uint8Array([7, 0, 0, 0]));
  return out.done();
}

const settle = async () => {
  for (let i = 0; i < 20; ++i) await Promise.resolve();
};

function world(t) {
  const timers = new Timers();
  t.after(() => timers.restore());
  const made = { dials: [], overSocket: [], slices: [], changes: [], now: 0 };
  const dial = (url, options) => {
    const transport = { url, options, sent: [], waiting: [], isClosed: false };
    transport.ready = new Promise((resolve, reject) => Object.assign(transport, { open: resolve, fail: reject }));
    transport.closed = new Promise((resolve) => (transport.end = resolve));
    transport.close = () => (transport.isClosed = true);
    transport.datagrams = {
      writable: { getWriter: () => ({ write: async (bytes) => void transport.sent.push(bytes) }) },
      readable: {
        getReader: () => ({ read: () => new Promise((resolve) => transport.waiting.push(resolve)) }),
      },
    };
    transport.bring = async (bytes) => {
      transport.waiting.shift()({ value: bytes, done: false });
      await settle();
    };
    made.dials.push(transport);
    return transport;
  };
  const carrier = new Carrier({
    socket: { url: 'wss://here:7600/session', send: (bytes) => made.overSocket.push(bytes) },
    dial,
    now: () => made.now,
    onSlice: (body) => made.slices.push(body),
    onChange: () => made.changes.push(carrier.name),
  });
  const pass = async (ms) => {
    for (let i = 0; i < ms; i += 10) {
      made.now += 10;
      timers.pass(10);
      carrier.tick();
    }
    await settle();
  };
  return { ...made, made, carrier, pass };
}

test('datagrams become the way once they are there, at the address and with the ticket that were told', async (t) => {
  const { carrier, dials, overSocket, slices, changes, pass } = world(t);
  await pass(5_000);
  assert.equal(dials.length, 0, 'nothing was offered');
  carrier.offered(offer);
  assert.equal(dials[0].url, 'https://here:7601/session?ticket=abc');
  assert.equal(dials[0].options.serverCertificateHashes[0].algorithm, 'sha-256');
  carrier.send(update, true);
  assert.equal(overSocket.length, 1, 'the WebSocket carries what is sent meanwhile');
  dials[0].open();
  await settle();
  assert.deepEqual(changes, ['WebTransport']);
  carrier.send(update, true);
  assert.equal(overSocket.length, 1);
  assert.equal(dials[0].sent[0][0], 1, 'a camera update');
  await dials[0].bring(slice(5));
  assert.deepEqual([...slices[0]], [7, 0, 0, 0]);
});

test('silence where an answer is due leads back, and at growing intervals another one is tried', async (t) => {
  const { carrier, dials, changes, pass, overSocket } = world(t);
  carrier.offered(offer);
  dials[0].open();
  await settle();
  await pass(10_000);
  assert.deepEqual(changes, ['WebTransport'], 'nothing was asked, so that silence means nothing');
  carrier.send(update, true);
  await pass(1_900);
  assert.equal(carrier.name, 'WebTransport');
  await pass(200);
  assert.deepEqual(changes, ['WebTransport', 'WebSocket']);
  assert.ok(dials[0].isClosed);
  carrier.send(update, true);
  assert.equal(overSocket.length, 1);
  await pass(2_100);
  assert.equal(dials.length, 2);
  await pass(3_100);
  assert.ok(dials[1].isClosed, 'no answer within the patience');
  await pass(3_600);
  assert.equal(dials.length, 2);
  await pass(600);
  assert.equal(dials.length, 3);
  dials[2].open();
  await settle();
  assert.equal(carrier.name, 'WebTransport');
});

test('a connection that ends leads back, a browser or a page without WebTransport stays', async (t) => {
  const { carrier, dials, changes } = world(t);
  carrier.offered(offer);
  dials[0].open();
  await settle();
  dials[0].end();
  await settle();
  assert.deepEqual(changes, ['WebTransport', 'WebSocket']);
  const without = world(t);
  without.carrier.dial = null;
  without.carrier.offered(offer);
  assert.equal(without.dials.length, 0);
});

test('hashes are named only where there are some', async (t) => {
  const { carrier, dials } = world(t);
  carrier.offered({ ...offer, hashes: [] });
  assert.ok(!('serverCertificateHashes' in dials[0].options));
});

test('what is lost is counted by sequence numbers, and above two percent it leads back for a while', () => {
  const every = (lost) => {
    const way = new Way();
    way.enter(0);
    for (let i = 0; i < 3_000; ++i) if (i % lost !== lost - 1) way.received(BigInt(100 + i), i);
    return way;
  };
  assert.equal(every(100).complaint(3_000), null);
  const way = every(30);
  assert.equal(way.complaint(3_000), 'loss');
  way.leave('loss', 3_000);
  assert.ok(!way.mayTry(32_000));
  assert.ok(way.mayTry(33_000));
});

test('while datagrams come, an answer that takes long is no silence', () => {
  const way = new Way();
  way.enter(0);
  way.asked(0);
  for (let now = 0; now < 5_000; now += 100) {
    way.received(BigInt(now / 100 + 1), now);
    assert.equal(way.complaint(now), null);
  }
});
