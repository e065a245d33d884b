// The figures of the head-up display.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Figures } from '../../web/ui/figures.js';

const frame = (at, bytes) => ({ at, responseMs: 20, serverUs: 5000, gpuUs: 3000, bytes });

test('they keep figures of frames, and not their masks', () => {
  const figures = new Figures();
  figures.frame({ ...frame(0, 1), words: new Uint32Array(8), lights: [{}] });
  assert.deepEqual(figures.frames, [frame(0, 1)]);
});

test('the bytes of another session are not those of the one before', () => {
  const figures = new Figures();
  figures.frame(frame(0, 1_000_000));
  figures.frame(frame(500, 1_500_000));
  assert.equal(figures.summary(500).kilobytesPerSecond, 1000);
  figures.frame(frame(1000, 1_000));
  assert.equal(figures.summary(1000).kilobytesPerSecond, 0);
  figures.frame(frame(1100, 2_000));
  assert.equal(figures.summary(1100).kilobytesPerSecond, 10);
});
