// What of soft light is averaged over masks; web_picture has the pictures.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { layersOf } from '../../web/render/accumulation.js';
import { OPEN_SEGMENTS, planesOf } from '../../web/wire/planes.js';
import { PARTS } from '../../web/render/shaders/accumulate.js';

test('shares are kept of lights that have an extent and rest', () => {
  const planes = planesOf([true, false, true, true], 4);
  assert.deepEqual(layersOf(planes, new Map()), [0, -1, 1, 2]);
  assert.deepEqual(layersOf(planes, new Map([[2, 7]])), [0, -1, -1, 1], 'light 2 is moved by node 7');
  assert.deepEqual(layersOf(planesOf([true, true], 1), new Map()), [-1, -1], 'hard shadows are never averaged');
});

test('means of up to four shares are whole numbers of parts', () => {
  for (const points of [4, 16, OPEN_SEGMENTS])
    for (const masks of [1, 2, 3, 4]) assert.equal(PARTS % (points * masks), 0, `${points} points, ${masks} masks`);
});
