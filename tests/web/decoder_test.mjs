// The decoder of browsers takes of every slice what the native client takes of it, to the last bit and word.
//
//   decoder_cases tests/fuzz/corpus/slices 200 | node decoder_test.mjs build/release/web/wasm/decoder.wasm
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { DecodeError, Decoder, Lane } from '../../web/decoder.js';
import { Codec } from '../../web/wire/messages.js';
import { Cases } from './cases.mjs';

const module = await WebAssembly.compile(readFileSync(process.argv[2]));
const decoder = await Decoder.load(module);

// A stream whose slices of tiles_context are decoded by lanes in turn, as link/lanes.js has them do.
class Apart {
  constructor(shape, seen) {
    this.stream = decoder.stream(shape);
    this.lanes = [0, 1].map(() => new Lane(decoder, shape));
    this.seen = seen;
    this.next = 0;
  }

  slice(body) {
    if (!this.stream.isLongWork(body)) return this.kept(this.stream.slice(body));
    const words = this.lanes[this.next++ % this.lanes.length].slice(body);
    this.seen[words ? 'apart' : 'givenBack']++;
    return this.kept(words ? this.stream.put(body, words) : this.stream.slice(body));
  }

  kept(frame) {
    if (frame && this.stream.have === frame.frame) for (const lane of this.lanes) lane.keep(frame.frame, frame.words);
    return frame;
  }

  get have() {
    return this.stream.have;
  }

  close() {
    for (const each of [this.stream, ...this.lanes]) each.close();
  }
}

// ---- what the native client says -------------------------------------------------------------------------------------

const input = readFileSync(0);

/** @param {(shape: object, seen: object) => any} open a stream */
function everySlice(open) {
  const cases = new Cases(input);
  const seen = { streams: 0, none: 0, whole: 0, malformed: 0, codecs: new Set(), referable: 0, apart: 0, givenBack: 0 };
  while (cases.left) {
    const shape = { width: cases.u32(), height: cases.u32(), lights: cases.u32() };
    const words = 2 * Math.ceil(shape.width / 8) * Math.ceil(shape.height / 8) * shape.lights;
    const stream = open(shape, seen);
    seen.streams++;
    for (let size = cases.u32(), n = 0; size !== 0xffffffff; size = cases.u32(), n++) {
      const body = cases.raw(size);
      const outcome = cases.u32();
      const have = cases.u32();
      const where = `stream ${seen.streams}, slice ${n}`;
      let frame = null;
      let refused = false;
      try {
        frame = stream.slice(body);
      } catch (error) {
        assert.ok(error instanceof DecodeError, `${where}: ${error.stack}`);
        refused = true;
      }
      assert.equal(refused ? 2 : frame ? 1 : 0, outcome, where);
      assert.equal(stream.have, have, where);
      seen[['none', 'whole', 'malformed'][outcome]]++;
      seen.referable += have !== 0;
      if (outcome !== 1) continue;
      const [number, sceneTimeUs, lightsVersion, serverUs, gpuUs, bytes, codec] = Array.from({ length: 7 }, () =>
        cases.u32(),
      );
      const { words: got, ...facts } = frame;
      assert.deepEqual(
        facts,
        { frame: number, ...shape, sceneTimeUs, lightsVersion, serverUs, gpuUs, bytes, codec },
        where,
      );
      assert.ok(Buffer.from(got.buffer).equals(cases.raw(4 * words)), `${where}: the words of frame ${number}`);
      seen.codecs.add(codec);
    }
    stream.close();
  }
  console.log(seen);
  // The cases are of every kind, else they would show little.
  assert.deepEqual([...seen.codecs].sort(), Object.values(Codec).sort());
  for (const kind of ['none', 'whole', 'malformed', 'referable']) assert.ok(seen[kind] > 100, kind);
  return seen;
}

test('every slice gives what the native client takes of it', () => everySlice((shape) => decoder.stream(shape)));

test('and so it does where lanes decode the slices', () => {
  const seen = everySlice((shape, seen) => new Apart(shape, seen));
  for (const kind of ['apart', 'givenBack']) assert.ok(seen[kind] > 100, kind);
});

// ---- WIRE.md's own packets -------------------------------------------------------------------------------------------

const wire = readFileSync(new URL('../../protocol/WIRE.md', import.meta.url), 'utf8');

function packet(name) {
  const block = wire.match(new RegExp('^```hex ' + name + '\\n([^]*?)^```', 'm'))[1];
  return Uint8Array.from(
    block
      .replace(/#.*/g, '')
      .match(/[0-9a-f]{2}/g)
      .map((digits) => parseInt(digits, 16)),
  );
}

// The body of a frame's only slice.
function body(frame, codec, tiles, lights, payload) {
  const out = new Uint8Array(32 + payload.length);
  const view = new DataView(out.buffer);
  view.setUint32(0, frame, true);
  view.setUint16(6, 1, true);
  view.setUint32(12, tiles, true);
  view.setUint16(18, lights, true);
  view.setUint8(20, codec);
  out.set(payload, 32);
  return out;
}

// Of light 0, then of light 1, the low half first.
const drawn = [0x070f1f3f, 0x00000103, 0xffffffff, 0xffffffff, 0, 0, 0x3c180000, 0x0000183c];

test("WIRE.md's FrameSlice is the mask that is drawn there", () => {
  const stream = decoder.stream({ width: 16, height: 8, lights: 2 });
  const frame = stream.slice(packet('frame_slice_body'));
  assert.deepEqual([...frame.words], drawn);
  assert.deepEqual([frame.frame, frame.codec, frame.serverUs, frame.gpuUs], [7, 1, 4200, 1500]);
  assert.equal(stream.have, 0);
});

test("WIRE.md's tiles_context, without and with a reference, is the same mask", () => {
  const stream = decoder.stream({ width: 16, height: 8, lights: 2 });
  const referring = body(7, Codec.tiles_context, 2, 2, packet('referenced_payload'));
  assert.equal(stream.slice(referring), null, 'frame 6 is not there yet');
  assert.deepEqual([...stream.slice(body(6, Codec.tiles_context, 2, 2, packet('context_payload'))).words], drawn);
  assert.equal(stream.have, 6);
  assert.deepEqual([...stream.slice(referring).words], drawn);
  assert.equal(stream.have, 7);
});

test("WIRE.md's payloads with LZ4 are dark", () => {
  const large = decoder.stream({ width: 512, height: 256, lights: 1 });
  assert.ok(large.slice(body(1, 1, 2048, 1, packet('dark_payload'))).words.every((word) => word === 0));
  const small = decoder.stream({ width: 8, height: 8, lights: 1 });
  assert.deepEqual([...small.slice(body(1, 0, 1, 1, packet('raw32_payload'))).words], [0, 0]);
});

// ---- sizes -----------------------------------------------------------------------------------------------------------

test('a slice that says no size is of the granted one', () => {
  const shape = { width: 16, height: 8, lights: 2 };
  const slice = packet('frame_slice_body');
  assert.equal(decoder.stream({ ...shape, granted: { width: 24, height: 8 } }).slice(slice), null);
  assert.ok(decoder.stream({ ...shape, granted: { width: 16, height: 8 } }).slice(slice));
  const granted = { width: 16, height: 8, samples: 16 };
  assert.equal(decoder.stream({ ...shape, samples: 4, granted }).slice(slice), null, 'it is of the granted samples');
  assert.ok(decoder.stream({ ...shape, samples: 16, granted }).slice(slice));
});

test('what is no mask is refused', () => {
  for (const shape of [
    [0, 8, 1],
    [8, 0, 1],
    [8, 8, 0],
    [7681, 8, 1],
    [8, 8, 256 * 5 + 4 + 1],
    [7680, 7680, 256],
    [-1, -1, -1],
  ]) {
    const [width, height, lights] = shape;
    assert.throws(() => decoder.stream({ width, height, lights }), RangeError, `${shape}`);
  }
  const stream = decoder.stream({ width: 8, height: 8, lights: 1 });
  assert.throws(() => stream.slice(new Uint8Array(1 << 17)), DecodeError);
  assert.throws(() => stream.slice(new Uint8Array(0)), DecodeError);
});

test('streams that are closed leave their memory to others', async () => {
  const own = await Decoder.load(module);
  const payload = packet('dark_payload');
  const round = () => {
    const stream = own.stream({ width: 512, height: 256, lights: 1 });
    for (let frame = 1; frame < 9; frame++) stream.slice(body(frame, 1, 2048, 1, payload));
    stream.close();
  };
  for (let i = 0; i < 8; i++) round();
  const size = own.exports.memory.buffer.byteLength;
  for (let i = 0; i < 200; i++) round();
  assert.equal(own.exports.memory.buffer.byteLength, size);
});
