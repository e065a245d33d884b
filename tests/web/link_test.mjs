// A session over a WebSocket that is none, in virtual time.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Credit } from '../../web/link/credit.js';
import { Client } from '../../web/link/client.js';
import { Move } from '../../web/link/move.js';
import { Timers } from './timers.mjs';
import { Writer } from '../../web/wire/bytes.js';
import { Type, decode } from '../../web/wire/messages.js';
import { writeCamera } from '../../web/wire/camera.js';
import { OCCLUSION } from '../../web/wire/planes.js';

const camera = (x) => ({
  position: [x, 0, 0],
  orientation: [0, 0, 0, 1],
  tanLeft: 1,
  tanRight: 1,
  tanUp: 1,
  tanDown: 1,
  near: 0.0625,
});

test('no more cameras are under way than there is credit', () => {
  const credit = new Credit({ limit: 2, rateHz: 0 });
  assert.ok(credit.isOpen(0));
  assert.equal(credit.sent(10, camera(0), 0), 1);
  assert.equal(credit.sent(11, camera(1), 1), 2);
  assert.ok(!credit.isOpen(50));
  assert.equal(credit.whole(2, 60).index, 11);
  assert.equal(credit.inFlight, 0); // frame 1 was replaced: the newest camera wins
  assert.equal(credit.whole(1, 61), null);
  assert.equal(credit.whole(7, 61), null); // never asked for
});

test('a window that nobody answers opens again after a patience that is learned', () => {
  const credit = new Credit({ limit: 1, rateHz: 0 });
  credit.sent(0, camera(0), 0);
  assert.equal(credit.opensAt, 10_000);
  credit.whole(1, 100);
  credit.sent(1, camera(1), 200);
  assert.equal(credit.opensAt, 1_200);
});

test('a granted rate is kept, without catching up after a pause', () => {
  const credit = new Credit({ limit: 9, rateHz: 10 });
  credit.sent(0, camera(0), 0);
  assert.ok(!credit.isOpen(99));
  assert.ok(credit.isOpen(100));
  credit.sent(1, camera(0), 1_000);
  assert.equal(credit.opensAt, 1_000);
  credit.sent(2, camera(0), 1_000);
  assert.equal(credit.opensAt, 1_100);
});

/** What a daemon would say, as bytes. */
function message(type, body) {
  const out = new Writer();
  out.u32(0);
  out.u16(type);
  body(out);
  out.view.setUint32(0, out.size - 4, true);
  return out.done().slice().buffer;
}

function welcome(lights = 1) {
  return message(Type.welcome, (out) => {
    out.u16(2);
    out.u64(1n);
    out.u64(5n);
    out.u16(7600);
    out.u8(1);
    out.u16(64);
    out.u16(32);
    out.f32(0);
    out.u8(1);
    out.u16(0);
    out.text('bvh', 256);
    out.u32(4000);
    out.text('temple', 1024);
    out.raw(new Uint8Array(16));
    out.u64(10n);
    out.floats([0, 0, 0, 1, 1, 1]);
    writeCamera(out, camera(0));
    out.u16(lights);
    for (let i = 0; i < lights; ++i) {
      out.u8(0);
      out.floats([0, 0, 0, 0, 0, 0, 1, 1, 1, 5, 0, 1, 0]);
    }
    out.u32(3);
    out.u16(0);
  });
}

/** Frames of one slice: the body is the frame's number alone. */
const decoder = {
  opened: [],
  slices: 0,
  most: Infinity, // planes
  stream(size) {
    this.opened.push(size);
    if (size.lights > this.most) throw new RangeError('too large');
    return {
      have: 0,
      close() {},
      slice(body) {
        decoder.slices += 1;
        const frame = new DataView(body.buffer, body.byteOffset).getUint32(0, true);
        if (body[4] === 255) throw new Error('malformed');
        return {
          frame,
          ...size,
          words: new Uint32Array(2),
          sceneTimeUs: 0,
          lightsVersion: 3,
          serverUs: 1,
          gpuUs: 1,
          codec: 1,
        };
      },
    };
  },
};
const slice = (frame, mark = 0) =>
  message(Type.data, (out) => {
    out.u8(2);
    out.u64(1n);
    out.u16(5);
    out.u32(frame);
    out.u8(mark);
  });

function world(t, more = {}) {
  const timers = new Timers();
  t.after(() => timers.restore());
  const events = [],
    sockets = [];
  let now = 0;
  decoder.opened.length = decoder.slices = 0;
  const client = new Client({
    decoder,
    now: () => now,
    move: new Move(() => 0.5),
    emit: (event) => events.push(event),
    connect: (url) => {
      const socket = {
        url,
        readyState: 1,
        sent: [],
        send(bytes) {
          this.sent.push(new Uint8Array(bytes).slice());
        },
        close() {
          this.readyState = 3;
        },
      };
      sockets.push(socket);
      return socket;
    },
  });
  const hello = {
    client: 'test',
    tenant: '',
    token: '',
    scene: 'temple',
    width: 64,
    height: 32,
    borderX: 0,
    borderY: 0,
    rateHz: 0,
    codecs: [1],
    ...more,
  };
  client.open('wss://here/session', hello);
  sockets[0].onopen();
  const pass = (ms) => {
    for (let i = 0; i < ms; i += 8) {
      now += 8;
      timers.pass(8);
    }
  };
  const say = (bytes, socket = sockets.at(-1)) => socket.onmessage({ data: bytes });
  const cameras = (socket = sockets.at(-1)) =>
    socket.sent
      .filter((bytes) => bytes[4] === Type.data)
      .map((bytes) => ({
        frame: new DataView(bytes.buffer).getUint32(17, true),
        x: new DataView(bytes.buffer).getFloat32(21, true),
      }));
  const of = (kind) => events.filter((event) => event.is === kind);
  return { client, events, sockets, pass, say, cameras, of };
}

test('cameras wait for Welcome and for credit; the newest one goes', (t) => {
  const { client, pass, say, cameras, of } = world(t);
  client.look(0, camera(0));
  pass(100);
  assert.equal(cameras().length, 0);
  say(welcome());
  for (let i = 1; i <= 6; ++i) client.look(i, camera(i));
  assert.deepEqual(
    cameras().map((each) => each.x),
    [0, 1, 2],
  );
  say(slice(3));
  assert.deepEqual(
    cameras().map((each) => each.x),
    [0, 1, 2, 6],
  );
  assert.equal(of('frame')[0].index, 2);
  assert.equal(of('frame')[0].lights.length, 1);
});

test('a client that rests shows signs of life with the same frame number', (t) => {
  const { client, pass, say, cameras } = world(t);
  say(welcome());
  client.look(0, camera(0));
  say(slice(1));
  pass(4_000);
  const frames = cameras().map((each) => each.frame);
  assert.ok(frames.length >= 4, `${frames}`);
  assert.ok(
    frames.every((frame) => frame === 1),
    `${frames}`,
  );
});

test('signs of life leave the patience for lost answers as it is', (t) => {
  const { client, pass, say, cameras } = world(t);
  say(welcome());
  for (let i = 0; i <= 3; ++i) client.look(i, camera(i));
  pass(9_900);
  const frames = cameras().map((each) => each.frame);
  assert.deepEqual(frames.slice(0, 3), [1, 2, 3]);
  assert.equal(frames.length, 3 + 9, 'one each quarter of the silence that the server bears');
  assert.ok(
    frames.slice(3).every((frame) => frame === 3),
    `${frames}`,
  );
  pass(200);
  assert.deepEqual([cameras().at(-1).frame, cameras().at(-1).x], [4, 3]);
});

test('a slice that is malformed costs its frame, a message that is malformed the session', (t) => {
  const { client, say, of, cameras } = world(t);
  say(welcome());
  client.look(0, camera(0));
  say(slice(1, 255));
  assert.equal(of('frame').length, 0);
  assert.equal(of('closed').length, 0);
  say(slice(1));
  assert.equal(of('frame').length, 1);
  say(new Uint8Array([9, 0, 0, 0, 4, 0]).buffer);
  assert.equal(of('closed').length, 1);
  assert.equal(cameras().length, 1);
});

test('a lost connection is opened again, and the newest camera is asked for again', (t) => {
  const { client, sockets, pass, say, cameras, of } = world(t);
  say(welcome());
  client.look(0, camera(0));
  client.look(1, camera(7));
  sockets[0].onclose({ reason: '' });
  assert.equal(of('closed')[0].againInMs, 250);
  pass(300);
  assert.equal(sockets.length, 2);
  sockets[1].onopen();
  assert.equal(decode(sockets[1].sent[0]), null); // Hello is no message for a client
  say(welcome());
  assert.deepEqual(
    cameras().map((each) => [each.frame, each.x]),
    [[1, 7]],
  );
});

test('who is kept out stays out, who does not fit is told what fits', (t) => {
  const kicked = world(t);
  kicked.say(welcome());
  kicked.say(
    message(Type.bye, (out) => {
      out.text('enough', 1024);
      out.u32(60_000);
    }),
  );
  assert.equal(kicked.of('closed')[0].againInMs, null);
  kicked.pass(20_000);
  assert.equal(kicked.sockets.length, 1);

  const fast = world(t, { rateHz: 60 });
  const refused = (rate) =>
    fast.say(
      message(Type.refused, (out) => {
        out.u16(9);
        out.text('full', 1024);
        out.u16(32);
        out.u16(16);
        out.f32(rate);
      }),
    );
  refused(20);
  assert.equal(fast.sockets.length, 2);
  fast.sockets[1].onopen();
  const rateAt = fast.sockets[1].sent[0].length - 2 - (2 + 1) - 4;
  assert.equal(new DataView(fast.sockets[1].sent[0].buffer).getFloat32(rateAt, true), 20);
  refused(5);
  assert.deepEqual(
    fast.of('fits').map((each) => each.width),
    [32],
  );

  const large = world(t);
  large.say(
    message(Type.refused, (out) => {
      out.u16(9);
      out.text('full', 1024);
      out.u16(32);
      out.u16(16);
      out.f32(0);
    }),
  );
  assert.deepEqual(large.of('fits'), [{ is: 'fits', width: 32, height: 16, text: 'full' }]);
});

test('a refusal does not hide why the session before was ended', (t) => {
  const { say, sockets, of, pass } = world(t);
  say(welcome());
  say(
    message(Type.bye, (out) => {
      out.text('its token was revoked', 1024);
      out.u32(0);
    }),
  );
  pass(300);
  sockets[1].onopen();
  say(
    message(Type.refused, (out) => {
      out.u16(4);
      out.text('the token is not that of this tenant', 1024);
      out.u16(0);
      out.u16(0);
      out.f32(0);
    }),
  );
  assert.deepEqual(
    of('closed').map((each) => each.why),
    ['its token was revoked', 'its token was revoked; and a new one: the token is not that of this tenant'],
  );
  assert.equal(of('closed')[1].againInMs, null);
});

/** One light, which is red. */
const lightsChanged = (version) =>
  message(Type.lightsChanged, (out) => {
    out.u16(1);
    out.u8(0);
    out.floats([0, 0, 0, 0, 0, 0, 1, 0, 0, 5, 0, 1, 0]);
    out.u32(version);
  });

test('a view at rest is asked for again where its lights change', (t) => {
  const { client, pass, say, cameras, of } = world(t);
  say(lightsChanged(2));
  say(welcome());
  pass(100);
  assert.equal(cameras().length, 0, 'there is no view yet');
  client.look(0, camera(7));
  say(slice(1));
  say(lightsChanged(3));
  assert.deepEqual(
    cameras().map((each) => [each.frame, each.x]),
    [
      [1, 7],
      [2, 7],
    ],
  );
  say(slice(2));
  const [before, after] = of('frame');
  assert.equal(after.index, before.index);
  assert.deepEqual(after.lights[0].color, [1, 0, 0]);
  pass(500);
  assert.equal(cameras().length, 2, 'once is enough');
});

test('lights that change all the time cost no frame that is under way', (t) => {
  const { client, pass, say, cameras, of } = world(t);
  say(welcome());
  for (let i = 0; i < 3; ++i) client.look(i, camera(i));
  for (let version = 3; version < 20; ++version) say(lightsChanged(version));
  pass(100);
  assert.equal(cameras().length, 3, 'there is no credit for more');
  say(slice(1));
  assert.equal(of('frame').at(-1).index, 0);
  assert.deepEqual([cameras().at(-1).frame, cameras().at(-1).x], [4, 2]);
});

/** Without `samples` as a session is told that has not the feature soft. */
function degraded(width, height, samples, untraced = []) {
  return message(Type.degraded, (out) => {
    out.u16(width);
    out.u16(height);
    out.f32(5);
    out.text('too much', 1024);
    out.u16(untraced.length);
    untraced.forEach((light) => out.u16(light));
    if (samples) out.u8(samples);
  });
}

test('a view at rest is asked for again where its size changes, and what was under way is dropped', (t) => {
  const { client, pass, say, cameras, of } = world(t);
  say(welcome());
  for (let i = 0; i < 3; ++i) client.look(i, camera(i));
  say(degraded(32, 16));
  assert.deepEqual([cameras().length, cameras().at(-1).frame, cameras().at(-1).x], [4, 4, 2], 'in spite of the credit');
  say(slice(3));
  assert.equal(of('frame').length, 0, 'it may be of either size');
  assert.equal(decoder.slices, 0, 'nor may others refer to it');
  say(slice(4));
  assert.deepEqual([of('frame')[0].index, of('frame')[0].width], [2, 32]);
  pass(200); // the rate that is granted now
  say(degraded(64, 32));
  assert.equal(cameras().at(-1).frame, 5);
  say(slice(5));
  assert.deepEqual([of('frame')[1].index, of('frame')[1].width], [2, 64]);
});

test('where only the lights that are traced change, what is under way stays good', (t) => {
  const { client, say, cameras, of } = world(t);
  say(welcome());
  client.look(0, camera(0));
  say(degraded(64, 32, 0, [0]));
  assert.equal(decoder.opened.length, 1);
  assert.equal(cameras().at(-1).frame, 2);
  say(slice(1));
  say(slice(2));
  assert.equal(of('frame').length, 2);
});

test('another size or scene opens the decoder anew, and older frames are dropped', (t) => {
  const { client, pass, say, cameras, of } = world(t);
  say(welcome());
  client.look(0, camera(0));
  say(degraded(32, 16));
  const granted = { width: 64, height: 32, samples: 1 };
  assert.deepEqual(decoder.opened.at(-1), { width: 32, height: 16, lights: 1, samples: 1, granted });
  say(
    message(Type.sceneChanged, (out) => {
      const bytes = new Uint8Array(welcome(2));
      out.raw(bytes.slice(bytes.length - 6 - 53 * 2 - 2 - 48 - 24 - 8 - 16 - 8, bytes.length - 6));
    }),
  );
  assert.equal(decoder.opened.at(-1).lights, 2);
  say(slice(1));
  say(slice(2));
  assert.equal(of('frame').length, 0);
  pass(200);
  assert.equal(cameras().at(-1).frame, 3, 'the view at rest is asked for again');
  say(slice(3));
  assert.equal(of('frame')[0].lights.length, 2);
});

/** As welcome(), with the feature soft: 16 points, unless other samples are said, and a sphere. */
function softWelcome(samples = 16) {
  const plain = new Uint8Array(welcome());
  const soft = new Uint8Array(plain.length + 3 + 25);
  soft.set(plain);
  const view = new DataView(soft.buffer);
  view.setUint32(0, soft.length - 4, true);
  view.setBigUint64(8, view.getBigUint64(8, true) | 1024n, true);
  view.setUint8(plain.length, samples);
  view.setUint16(plain.length + 1, 1, true);
  view.setUint8(plain.length + 3, 1);
  return soft.buffer;
}

test('masks of area lights have as many planes as the samples in force ask for', (t) => {
  const { client, say, of } = world(t);
  say(softWelcome());
  const granted = { width: 64, height: 32, samples: 16 };
  assert.deepEqual(decoder.opened.at(-1), { width: 64, height: 32, lights: 5, samples: 16, granted });
  say(degraded(64, 32, 4));
  assert.deepEqual(decoder.opened.at(-1), { width: 64, height: 32, lights: 3, samples: 4, granted });
  client.look(0, camera(0));
  say(slice(1));
  assert.deepEqual(of('frame').at(-1).planes, { first: [0], samples: [4], occlusion: -1, halved: false, total: 3 });
  say(degraded(64, 32, 16));
  assert.equal(decoder.opened.at(-1).lights, 5);
});

test('a page whose ambient light is degraded keeps what a quarter of the pixels counts', (t) => {
  const { client, pass, say, cameras, of } = world(t);
  say(softWelcome(16 + OCCLUSION.full));
  const planes = () => {
    client.look(of('frame').length, camera(0));
    pass(200);
    say(slice(cameras().at(-1).frame));
    return of('frame').at(-1).planes;
  };
  assert.deepEqual(planes(), { first: [0], samples: [16], occlusion: 5, halved: false, total: 9 });
  say(degraded(64, 32, 4 + OCCLUSION.half));
  assert.deepEqual(planes(), { first: [0], samples: [4], occlusion: 3, halved: true, total: 7 });
  say(degraded(64, 32, 4));
  assert.deepEqual(planes(), { first: [0], samples: [4], occlusion: -1, halved: false, total: 3 });
});

test('masks that are too large for the browser are asked for with one point', (t) => {
  const { client, sockets, say, of } = world(t);
  decoder.most = 4;
  t.after(() => (decoder.most = Infinity));
  client.hello = { ...client.hello, samples: 16 };
  say(softWelcome());
  assert.equal(of('open').length, 0);
  assert.equal(of('closed').length, 0);
  assert.equal(sockets.length, 2);
  assert.equal(client.hello.samples, 1);
  sockets[1].onmessage({ data: welcome() });
  assert.equal(of('open').length, 1);
  assert.equal(decoder.opened.at(-1).lights, 1);
});

const draining = (deadlineMs, flags) =>
  message(Type.draining, (out) => {
    out.u32(deadlineMs);
    out.u8(flags);
  });
const byes = (socket) => socket.sent.filter((bytes) => bytes[4] === Type.bye).length;

test('where a server of a fleet drains, another session answers before the first one ends', (t) => {
  const { client, sockets, pass, say, cameras, of } = world(t);
  const [old] = sockets;
  say(welcome());
  client.look(0, camera(0));
  say(slice(1));
  say(draining(10_000, 1));
  pass(480); // half of a tenth of the time that is left
  assert.equal(sockets.length, 1);
  pass(40);
  assert.equal(sockets.length, 2);
  const [, next] = sockets;
  next.onopen();
  client.look(1, camera(1));
  say(slice(2), old);
  assert.deepEqual(
    of('frame').map((each) => each.index),
    [0, 1],
  );
  say(welcome(), next);
  assert.deepEqual(
    cameras(next).map((each) => [each.frame, each.x]),
    [[1, 1]],
    'the newest camera, though it has been answered',
  );
  client.look(2, camera(2));
  assert.equal(cameras(old).at(-1).x, 2);
  assert.equal(cameras(next).at(-1).x, 2);
  assert.equal(of('open').length, 1);
  assert.equal(byes(old), 0);
  say(slice(1), next);
  assert.equal(of('frame').length, 2, 'answered before');
  assert.equal(byes(old), 1);
  assert.equal(of('open').length, 2);
  say(slice(2), next);
  assert.deepEqual(
    of('frame').map((each) => each.index),
    [0, 1, 2],
  );
  const before = cameras(old).length;
  client.look(3, camera(3));
  assert.equal(cameras(old).length, before);
  assert.equal(of('closed').length, 0);
  assert.equal(of('connecting').length, 1);
});

test('a move that is refused is tried again, and one that is taken back is not begun', (t) => {
  const { client, sockets, pass, say, of } = world(t);
  const [old] = sockets;
  say(welcome());
  client.look(0, camera(0));
  say(draining(0, 1));
  pass(8);
  assert.equal(sockets.length, 2);
  for (const wait of [450, 900]) {
    const next = sockets.at(-1);
    next.onopen();
    say(
      message(Type.refused, (out) => {
        out.u16(6);
        out.text('not here', 1024);
        out.u16(0);
        out.u16(0);
        out.f32(0);
      }),
      next,
    );
    const opened = sockets.length;
    pass(wait - 16);
    assert.equal(sockets.length, opened);
    pass(32);
    assert.equal(sockets.length, opened + 1);
  }
  say(draining(0xffffffff, 0), old);
  assert.equal(sockets.at(-1).readyState, 3, 'it is given up');
  const opened = sockets.length;
  pass(10_000);
  assert.equal(sockets.length, opened);
  say(slice(1), old);
  assert.equal(of('frame').length, 1);
  assert.equal(of('closed').length, 0);
});

test('a session that ends before the move is done is replaced by the one on its way', (t) => {
  const { client, sockets, pass, say, of } = world(t);
  const [old] = sockets;
  say(welcome());
  client.look(0, camera(0));
  say(draining(0, 1));
  pass(8);
  const [, next] = sockets;
  next.onopen();
  old.onclose({ reason: '' });
  assert.equal(of('closed').length, 0);
  say(welcome(), next);
  say(slice(1), next);
  assert.equal(of('frame').length, 1);
  next.onclose({ reason: '' });
  assert.equal(of('closed').length, 1, 'nothing is on its way now');
});

test('servers that ask for no move are left when they end', (t) => {
  const { client, sockets, pass, say } = world(t);
  say(welcome());
  client.look(0, camera(0));
  say(
    message(Type.draining, (out) => {
      out.u32(5_000); // of an older server, without flags
    }),
  );
  pass(4_000);
  assert.equal(sockets.length, 1);
});
