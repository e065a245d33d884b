// The reader of scene packs: what is damaged is said in a sentence, whatever it is; the download says how far it is.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { fetchPack, PackError, ScenePack } from '../../web/pack/pack.js';

/** A pack of one triangle; `change` may break its JSON before it is written, `damage` its sections. */
function pack({ change = () => {}, damage = () => {} } = {}) {
  const sizes = { positions: 36, normals: 36, uvs: 24, triangles: 12, triangle_materials: 4 };
  const JSON_BYTES = 1024 - 16;
  let offset = 16 + JSON_BYTES;
  const sections = {};
  for (const [name, bytes] of Object.entries(sizes)) {
    sections[name] = { offset, bytes };
    offset += Math.ceil(bytes / 16) * 16;
  }
  const buffer = new ArrayBuffer(offset);
  const info = { name: 'one', materials: [{}], sections };
  change(info);
  new Uint8Array(buffer).set(new TextEncoder().encode('GNPACK01'));
  new DataView(buffer).setUint32(8, JSON_BYTES, true);
  const text = JSON.stringify(info).padEnd(JSON_BYTES);
  new Uint8Array(buffer).set(new TextEncoder().encode(text), 16);
  new Uint32Array(buffer, sections.triangles.offset, 3).set([0, 1, 2]);
  damage(buffer, sections);
  return buffer;
}

test('a pack is read where it lies', () => {
  const read = new ScenePack(pack());
  assert.equal(read.triangleCount, 1);
  assert.equal(read.vertexCount, 3);
  assert.deepEqual([...read.triangles], [0, 1, 2]);
  assert.equal(read.positions.buffer, read.buffer);
});

const broken = {
  nothing: () => new ArrayBuffer(0),
  'another file': () => pack({ damage: (buffer) => new Uint8Array(buffer).fill(0x20, 0, 8) }),
  'a pack without its end': () => pack().slice(0, 600),
  'a pack without its last section': () => pack().slice(0, 1040),
  'a section beyond the end': () => pack({ change: ({ sections }) => (sections.uvs.bytes = 1 << 20) }),
  'a section before the beginning': () => pack({ change: ({ sections }) => (sections.uvs.offset = -16) }),
  'a section between two numbers': () => pack({ change: ({ sections }) => (sections.normals.offset += 2) }),
  'no section': () => pack({ change: ({ sections }) => delete sections.normals }),
  'lists of different lengths': () => pack({ change: ({ sections }) => (sections.normals.bytes = 24) }),
  'a vertex that is not there': () =>
    pack({ damage: (buffer, { triangles }) => new Uint32Array(buffer, triangles.offset, 3).fill(3) }),
  'a material that is not there': () =>
    pack({ damage: (buffer, sections) => new Uint32Array(buffer, sections.triangle_materials.offset, 1).fill(9) }),
  'no JSON': () => pack({ damage: (buffer) => new Uint8Array(buffer).fill(0x7b, 16, 24) }),
};
for (const [what, make] of Object.entries(broken))
  test(`${what} is refused in a sentence`, () => {
    assert.throws(
      () => new ScenePack(make()),
      (error) => error instanceof PackError && /^[A-Z].*\.$/.test(error.message),
    );
  });

/** A server that answers in pieces. */
function serving(buffer, { status = 200, headers = {}, piece = 100 } = {}) {
  globalThis.fetch = async () => {
    let at = 0;
    const body = new ReadableStream({
      pull(controller) {
        if (at >= buffer.byteLength) return controller.close();
        controller.enqueue(new Uint8Array(buffer.slice(at, at + piece)));
        at += piece;
      },
    });
    return new Response(status === 200 ? body : null, { status, headers });
  };
}

for (const [what, options] of Object.entries({
  'the length that the scene states': { bytes: pack().byteLength },
  'the length of the answer': { headers: { 'Content-Length': String(pack().byteLength) } },
  'no length': { headers: { 'Content-Encoding': 'br', 'Content-Length': '70' }, unknown: true },
  'a length that is too small': { bytes: 64 },
}))
  test(`a download with ${what}`, async () => {
    const told = [];
    serving(pack(), options);
    const whole = await fetchPack('/scene', { bytes: options.bytes, onProgress: (...step) => told.push(step) });
    const read = new ScenePack(whole);
    assert.equal(read.triangleCount, 1);
    assert.equal(told.at(-1)[0], pack().byteLength);
    assert.ok(told.every(([done], i) => i === 0 || done > told[i - 1][0]));
    if (options.unknown) assert.equal(told.at(-1)[1], 0);
  });

test('a refusal says its status', async () => {
  serving(pack(), { status: 404 });
  await assert.rejects(fetchPack('/scene'), (error) => error instanceof PackError && error.message.includes('404'));
});
