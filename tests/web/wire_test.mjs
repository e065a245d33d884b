// The page's wire messages against the worked packets of protocol/WIRE.md.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { readFileSync } from 'node:fs';
import { Malformed } from '../../web/wire/bytes.js';
import * as messages from '../../web/wire/messages.js';
import { fewest, hardPlanes, OCCLUSION, planesOf, seenOf } from '../../web/wire/planes.js';

const document = readFileSync(new URL('../../protocol/WIRE.md', import.meta.url), 'utf8');

/** The bytes of the block that the document names so. */
function packet(name) {
  const block = new RegExp('```hex ' + name + '\\n([^`]*)```').exec(document);
  assert.ok(block, `protocol/WIRE.md has no packet ${name}`);
  const digits = block[1]
    .split('\n')
    .map((line) => line.replace(/#.*/, ''))
    .join(' ')
    .match(/\b[0-9a-f]{2}\b/g);
  return Uint8Array.from(digits, (pair) => parseInt(pair, 16));
}

test('a Hello is that of the document but for its features', () => {
  const hello = messages.encodeHello({
    client: 'probe 1',
    tenant: '',
    token: '',
    scene: 'temple',
    width: 1984,
    height: 1116,
    borderX: 64,
    borderY: 36,
    rateHz: 60,
    codecs: [messages.Codec.tiles_lz4],
  });
  const expected = packet('hello');
  assert.equal(new DataView(expected.buffer).getBigUint64(10, true), 0n);
  const { moments, references, sizes, paths, waiting, fleet } = messages.Feature;
  new DataView(expected.buffer).setBigUint64(10, moments + references + sizes + paths + waiting + fleet, true);
  assert.deepEqual([...hello], [...expected]);
});

test('who wants soft shadows says how many points', () => {
  const hello = {
    client: 'probe 1',
    tenant: '',
    token: '',
    scene: 'temple',
    width: 64,
    height: 64,
    borderX: 0,
    borderY: 0,
    rateHz: 60,
    codecs: [1],
  };
  const hard = messages.encodeHello(hello);
  const soft = messages.encodeHello({ ...hello, samples: 16 });
  assert.deepEqual([...messages.encodeHello({ ...hello, samples: 1 })], [...hard]);
  assert.equal(soft.length, hard.length + 1);
  assert.equal(soft.at(-1), 16);
  const features = (bytes) => new DataView(bytes.buffer).getBigUint64(10, true);
  assert.equal(features(soft), features(hard) + messages.Feature.soft);
});

/** The document's Welcome with what the feature soft adds: the samples, and a shape for each light. */
function softWelcome(samples, shape) {
  const plain = packet('welcome');
  const bytes = new Uint8Array(plain.length + 1 + 2 + 25);
  bytes.set(plain);
  const view = new DataView(bytes.buffer);
  view.setUint32(0, bytes.length - 4, true);
  view.setBigUint64(8, view.getBigUint64(8, true) | messages.Feature.soft, true);
  view.setUint8(plain.length, samples);
  view.setUint16(plain.length + 1, 1, true);
  view.setUint8(plain.length + 3, shape);
  return bytes;
}

test('a Welcome says which lights have an extent, and of how many points', () => {
  const hard = messages.decode(packet('welcome'));
  assert.deepEqual([hard.samples, hard.areas], [1, [false]]);
  const soft = messages.decode(softWelcome(16, 2));
  assert.deepEqual([soft.samples, soft.areas], [16, [true]]);
  assert.deepEqual(messages.decode(softWelcome(4, 0)).areas, [false]);
  assert.throws(() => messages.decode(softWelcome(5, 1)), Malformed);
  assert.equal(messages.decode(softWelcome(4 + OCCLUSION.full, 1)).samples, 4 + OCCLUSION.full);
  assert.throws(() => messages.decode(softWelcome(4 + 192, 1)), Malformed);
  assert.throws(() => messages.decode(softWelcome(4, 4)), Malformed);
  assert.equal(messages.decode(packet('degraded')).samples, 4);
});

test('of two kinds of samples the fewest are no more than either, part by part', () => {
  assert.equal(fewest(16, 4 + OCCLUSION.full), 4);
  assert.equal(fewest(16 + OCCLUSION.full, 4 + OCCLUSION.half), 4 + OCCLUSION.half);
  assert.equal(fewest(1 + OCCLUSION.full, 16 + OCCLUSION.full), 1 + OCCLUSION.full);
});

test('planes are numbered as common/light_planes.h has them, and count points', () => {
  const planes = planesOf([false, true, true], 16);
  assert.deepEqual(planes, { first: [0, 1, 6], samples: [1, 16, 16], occlusion: -1, halved: false, total: 11 });
  assert.deepEqual(planesOf([true], 4), { first: [0], samples: [4], occlusion: -1, halved: false, total: 3 });
  assert.deepEqual(hardPlanes(2), { first: [0, 1], samples: [1, 1], occlusion: -1, halved: false, total: 2 });
  const occluded = planesOf([false, true], 4 + OCCLUSION.full);
  assert.deepEqual(occluded, { first: [0, 1], samples: [1, 4], occlusion: 4, halved: false, total: 8 });
  const half = planesOf([false], 1 + OCCLUSION.half);
  assert.deepEqual(half, { first: [0], samples: [1], occlusion: 1, halved: true, total: 5 });
  const count = (set) => seenOf(planes, 1, (plane) => Number(set.includes(plane)));
  assert.equal(count([1, 2, 5]), 16, 'the first plane is that of all');
  assert.equal(count([2, 4]), 10, 'most significant first');
  assert.equal(count([5]), 1);
  assert.equal(count([]), 0);
  assert.equal(seenOf(planes, 0, () => 1), 1);
  assert.equal(seenOf(planes, 0, () => 0), 0);
});

test('a Welcome is read', () => {
  const welcome = messages.decode(packet('welcome'));
  assert.equal(welcome.is, 'welcome');
  assert.equal(welcome.session, '1122334455667788');
  assert.deepEqual([welcome.width, welcome.height, welcome.rateHz, welcome.codec], [1280, 640, 30, 1]);
  assert.deepEqual(welcome.passes, ['shadows']);
  assert.equal(welcome.silenceTimeoutMs, 5000);
  assert.equal(welcome.scene.contentHash, '000102030405060708090a0b0c0d0e0f');
  assert.deepEqual(welcome.scene.defaultCamera.position, [1, 1.5, -2]);
  assert.equal(welcome.scene.defaultCamera.near, 0.0625);
  assert.equal(welcome.scene.lights[0].intensity, 40);
  assert.equal(welcome.scene.lights[0].outerConeCos, 0.5);
  assert.equal(welcome.lightsVersion, 3);
  assert.deepEqual(welcome.motions, [{ node: 'fan', kind: 'spin', vector: [0, 1, 0], periodUs: 2_000_000 }]);
});

test('Refused, Waiting and Bye are read', () => {
  assert.deepEqual(messages.decode(packet('refused')), {
    is: 'refused',
    code: 9,
    text: 'full',
    fitWidth: 640,
    fitHeight: 320,
    fitRateHz: 15,
  });
  assert.deepEqual(messages.decode(packet('waiting')), { is: 'waiting', text: 'reading the scene', percent: 40 });
  assert.deepEqual(messages.decode(packet('bye')), { is: 'bye', reason: 'too far', stayOutMs: 60_000 });
});

test('the way to datagrams is read', () => {
  const offered = messages.decode(packet('webtransport'));
  assert.deepEqual([offered.is, offered.port, offered.ticket], ['webTransport', 7600, 'ticket001']);
  assert.deepEqual(offered.hashes, [Uint8Array.from({ length: 32 }, (_, i) => i)]);
});

test('a camera update is that of the document, without its acknowledgement', () => {
  const data = messages.cameraMessage({
    frame: 7,
    timeUs: 1_000_000,
    deadlineUs: 50_000,
    have: 0,
    camera: {
      position: [1, 1.5, -2],
      orientation: [0, 0.6, 0, 0.8],
      tanLeft: 0.75,
      tanRight: 0.75,
      tanUp: 0.5,
      tanDown: 0.5,
      near: 0.0625,
    },
  });
  const body = packet('camera_update_body').slice(0, 64);
  assert.deepEqual(
    [...data.slice(0, 17)],
    [...[80 + 4, 0, 0, 0, 10, 0, 1], ...Array(8).fill(0), 69, 0].map((byte, i) => (i === 0 ? data.length - 4 : byte)),
  );
  assert.deepEqual([...data.slice(17, 17 + 64)], [...body]);
  assert.deepEqual([...data.slice(17 + 64)], [0, 0, 0, 0, 0]);
});

test('every shorter Welcome and every byte beyond is handled', () => {
  const welcome = packet('welcome');
  for (let size = 6; size < welcome.length; ++size) {
    const cut = welcome.slice(0, size);
    new DataView(cut.buffer).setUint32(0, size - 4, true);
    assert.throws(() => messages.decode(cut), Malformed, `${size} bytes`);
  }
  const longer = new Uint8Array([...welcome, 1, 2, 3]);
  new DataView(longer.buffer).setUint32(0, longer.length - 4, true);
  assert.equal(messages.decode(longer).is, 'welcome');
});

test('values that the document forbids are malformed, unknown types are skipped', () => {
  const refused = packet('refused');
  const changed = (at, bytes) => {
    const copy = refused.slice();
    copy.set(bytes, at);
    return copy;
  };
  const rate = refused.length - 4;
  assert.throws(() => messages.decode(changed(rate, [0, 0, 0x80, 0x7f])), Malformed); // infinite
  assert.throws(() => messages.decode(changed(rate, [0, 0, 0x80, 0xbf])), Malformed); // -1
  assert.throws(() => messages.decode(changed(10, [0x07])), Malformed); // a control character
  assert.throws(() => messages.decode(changed(0, [0x13])), Malformed); // another length
  assert.equal(messages.decode(changed(4, [0xff, 0x7f])), null);
});

test('whether to move is read, and an older Draining has not said it', () => {
  const draining = packet('draining');
  assert.deepEqual(messages.decode(draining), { is: 'draining', deadlineMs: 40_000, moveNow: true });
  const endless = draining.slice().fill(0xff, 6, 10);
  assert.equal(messages.decode(endless).deadlineMs, Infinity);
  const older = draining.slice(0, -1);
  new DataView(older.buffer).setUint32(0, older.length - 4, true);
  assert.deepEqual(messages.decode(older), { is: 'draining', deadlineMs: 40_000, moveNow: false });
});
