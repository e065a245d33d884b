// What is asked for again, and for how long.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { again } from '../../web/link/again.js';
import { Timers } from './timers.mjs';

const lost = () => Promise.reject(new TypeError('Failed to fetch'));
const settle = () => new Promise((resolve) => setImmediate(resolve));

function inVirtualTime(t) {
  const timers = new Timers();
  t.after(() => timers.restore());
  return timers;
}

/** Answers in turn; the last one stays. */
function serving(...answers) {
  const served = { count: 0 };
  served.attempt = () => answers[Math.min(served.count++, answers.length - 1)]();
  return served;
}

test('what the network took away is asked for again, each time later', async (t) => {
  const timers = inVirtualTime(t);
  const served = serving(lost, lost, lost, async () => 'whole');
  const told = [];
  const result = again(served.attempt, { onLoss: (error) => told.push([timers.now, error.message]) });
  for (let i = 0; i < 40; ++i) {
    await settle();
    timers.pass(50);
  }
  assert.equal(await result, 'whole');
  assert.equal(served.count, 4);
  const times = told.map(([at]) => at);
  assert.ok(times[2] - times[1] > times[1] - times[0], `${times}`);
  assert.equal(told[0][1], 'Failed to fetch');
});

test('what is wrong otherwise is said at once', async (t) => {
  inVirtualTime(t);
  const served = serving(() => Promise.reject(new Error('404')));
  await assert.rejects(again(served.attempt), /404/);
  assert.equal(served.count, 1);
});

test('what is no longer wanted is asked for no more', async (t) => {
  const timers = inVirtualTime(t);
  const served = serving(lost);
  let wanted = true;
  const result = again(served.attempt, { isWanted: () => wanted });
  await settle();
  wanted = false;
  timers.pass(10_000);
  await assert.rejects(result, TypeError);
  assert.equal(served.count, 2);
});
