// The page's prediction against the native client's, on the same random cameras.
//
//   web_prediction_vectors | node prediction_test.mjs     as the test web_prediction does
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { readFileSync } from 'node:fs';
import * as border from '../../web/prediction/border.js';
import { ErrorBalance, ErrorCurve } from '../../web/prediction/error_balance.js';
import { motionBetween } from '../../web/prediction/motion.js';
import { ShowOrder } from '../../web/prediction/show_order.js';
import { Gaze } from '../../web/ui/gaze.js';
import { rotate } from '../../web/prediction/vector.js';

const size = { width: 1280, height: 720, borderX: 64, borderY: 48 };
const lines = readFileSync(0, 'utf8')
  .trim()
  .split('\n')
  .map((line) => JSON.parse(line));
assert.equal(lines.length, 200);

const near = (got, expected, by, what) =>
  [got]
    .flat()
    .forEach((value, i) =>
      assert.ok(Math.abs(value - [expected].flat()[i]) <= by, `${what}: ${got}, not ${expected}`),
    );
const tangents = (camera) => [camera.tanLeft, camera.tanRight, camera.tanUp, camera.tanDown];

test('the border, its place and the shown part are the native ones', () => {
  for (const line of lines) {
    const place = border.towards(size, line.before, line.now);
    assert.deepEqual(place, line.place);
    const traced = border.viewOf(line.before, size, place);
    near(tangents(traced), line.traced, 2e-7, 'traced');
    assert.deepEqual(border.placeOf(traced, size), line.again);
    near(tangents(border.shownPart(traced, size)), line.shown, 3e-7, 'shown');
  }
});

test('a camera that goes on goes where the native one does', () => {
  for (const line of lines) {
    const then = border.extrapolate(line.before, line.now, 3);
    near(then.position, line.then.position, 2e-5, 'position');
    for (const axis of [
      [0, 0, -1],
      [0, 1, 0],
    ]) {
      near(rotate(then.orientation, axis), rotate(line.then.orientation, axis), 2e-3, 'orientation');
    }
  }
});

test('motions and expected errors are the native ones', () => {
  const curve = new ErrorCurve(size);
  for (const line of lines) {
    const traced = border.viewOf(line.before, size, line.place);
    const later = border.viewOf(line.now, size, border.centred(size));
    const motion = motionBetween(traced, later, size, 4);
    near(motion.unseen, line.motion.unseen, 1.5 / 84, 'unseen'); // a point at the very edge may fall either way
    near([motion.turn, motion.shift], [line.motion.turn, line.motion.shift], 0.02, 'motion');
    curve.learn(line.motion, line.error);
    near(curve.expect(line.motion), line.expected, 1e-6, 'expected');
  }
});

test('pictures never go back, and a still camera is shown once', () => {
  const order = new ShowOrder(new ErrorBalance({ size }));
  const camera = (x) =>
    border.viewOf({ position: [x, 0, 0], orientation: [0, 0, 0, 1], verticalFov: 0.9 }, size, border.centred(size));
  for (let i = 0; i < 10; ++i) order.asked(camera(i / 100), 16 * i);
  assert.equal(order.next(160), null);
  assert.ok(order.answered(4));
  const first = order.next(160);
  assert.ok(first.camera.index >= 4 && first.seen.index === 4);
  assert.equal(order.next(160), null);
  assert.ok(!order.answered(3));
  assert.ok(order.answered(5));
  assert.ok(order.next(176).camera.index >= first.camera.index);
});

test('a gaze is the pose that it was made of, but for its roll', () => {
  for (const line of lines) {
    const pose = Gaze.of(line.now).pose;
    near(rotate(pose.orientation, [0, 0, -1]), rotate(line.now.orientation, [0, 0, -1]), 1e-5, 'forward');
    assert.ok(Math.abs(rotate(pose.orientation, [1, 0, 0])[1]) < 1e-9, 'the horizon is level');
  }
});
