// What many masks of one view say together, beside a count of each surface point by itself.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { BLOCK, Gathering } from '../../web/render/gathering.js';
import { PARTS } from '../../web/render/shaders/accumulate.js';
import { OPEN_SEGMENTS, planesOf, seenOf } from '../../web/wire/planes.js';
import { difference } from '../../web/side_by_side.js';

const SIZE = { width: 13, height: 9 };
const TRACED = { width: SIZE.width + 8, height: SIZE.height + 8 };

/** Numbers of a generator, the same in each run. */
function numbers(seed) {
  let state = seed;
  return (below) => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return Math.floor((state / 2 ** 32) * below);
  };
}

/** Masks whose counts are what `count(layer, x, y)` says, by pixel of the masks. */
function masksOf(planes, count) {
  const tilesX = Math.ceil(TRACED.width / 8),
    tilesY = Math.ceil(TRACED.height / 8);
  const words = new Uint32Array(2 * tilesX * tilesY * planes.total);
  const set = (plane, x, y) => {
    const bit = (y & 7) * 8 + (x & 7);
    words[2 * ((plane * tilesY + (y >> 3)) * tilesX + (x >> 3)) + (bit >> 5)] |= 1 << (bit & 31);
  };
  const put = (first, most, number, x, y) => {
    if (number === most) return set(first, x, y);
    const bits = Math.log2(most);
    for (let i = 0; i < bits; ++i) if ((number >> (bits - 1 - i)) & 1) set(first + 1 + i, x, y);
  };
  for (let y = 0; y < TRACED.height; ++y)
    for (let x = 0; x < TRACED.width; ++x) {
      planes.first.forEach((first, light) => put(first, planes.samples[light], count(light, x, y), x, y));
      put(planes.occlusion, OPEN_SEGMENTS, count('ambient', x, y), x, y);
    }
  return { ...TRACED, words, planes };
}

test('means over all places of a block are those of every count of the surface', () => {
  const planes = planesOf([true, false, true], 16 + 128);
  const layers = [0, -1, 1];
  const gathering = new Gathering(SIZE, planes, layers);
  const next = numbers(7);
  const sums = new Map();
  let masks, place;
  for (let i = 0; i < BLOCK * BLOCK; ++i) {
    place = { left: i % BLOCK, top: Math.floor(i / BLOCK) };
    const { left, top } = place;
    masks = masksOf(planes, (light, x, y) => {
      const most = light === 'ambient' ? OPEN_SEGMENTS : planes.samples[light];
      const number = next(3) === 0 ? most : next(most + 1);
      const key = `${light} ${x - left} ${y - top}`;
      sums.set(key, (sums.get(key) ?? 0) + number);
      return number;
    });
    assert.equal(seenOf(planes, 1, () => 1), 1, 'a light without an extent has one bit');
    gathering.add(masks, place);
  }
  const { width, height, shares } = gathering.shares(masks, place);
  assert.deepEqual([width, height, shares.length], [TRACED.width, TRACED.height, 3 * TRACED.width * TRACED.height]);
  const of = [
    [0, 0, 16],
    [1, 2, 16],
    [2, 'ambient', OPEN_SEGMENTS],
  ];
  const seen = new Set();
  for (const [layer, light, most] of of)
    for (let y = 0; y < SIZE.height; ++y)
      for (let x = 0; x < SIZE.width; ++x) {
        const share = shares[(layer * TRACED.height + y + place.top) * TRACED.width + x + place.left];
        assert.equal(share, Math.round((PARTS * sums.get(`${light} ${x} ${y}`)) / (most * BLOCK * BLOCK)));
        seen.add(share);
      }
  assert.ok(seen.size > 30, 'many shares');
});

test('what is lit in every view is so in their mean, and what is dark is dark', () => {
  const planes = planesOf([true], 16 + 128);
  for (const lit of [0, 1]) {
    const gathering = new Gathering(SIZE, planes, [0]);
    const masks = masksOf(planes, (light) => (light === 'ambient' ? lit * OPEN_SEGMENTS : lit * 16));
    for (let i = 0; i < 5; ++i) gathering.add(masks, { left: 2, top: 3 });
    const { shares } = gathering.shares(masks, { left: 2, top: 3 });
    assert.equal(shares[3 * TRACED.width + 2], lit * PARTS);
  }
});

test('the difference of two pictures is that of their colours', () => {
  assert.equal(difference(Uint8Array.of(3, 3, 3, 0), Uint8Array.of(0, 0, 0, 255)), 3);
});
