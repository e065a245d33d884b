// The figures of the operators' page, by its script as it is served. tests/system/ops/page_test.py opens the page itself.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

const element = () => ({ setAttribute() {}, append() {}, replaceChildren() {}, addEventListener() {} });
const page = vm.createContext({
  document: { getElementById: element, createElement: element, createElementNS: element },
  performance,
  fetch: () => new Promise(() => {}),
  AbortSignal: { timeout() {} },
});
vm.runInContext(readFileSync(new URL('../../daemon/admin/page/page.js', import.meta.url), 'utf8'), page);

const session = (id, frames, totalUs, tenant = 'lab') => ({ id, tenant, frames, total_us: totalUs });
const status = (...sessions) => ({ sessions, tenants: [{ name: 'lab', buffers: 0, bytes: 0 }] });
const latency = (now, before) => page.figures(now.tenants[0], now, before, 1).total_ms;

test('a session counts as often as it was answered since the look before', () => {
  const before = status(session('1', 1000, 5000), session('2', 50, 9000));
  const now = status(session('1', 1090, 10_000), session('2', 60, 110_000), session('3', 99, 700_000, 'arcade'));
  assert.equal(latency(now, before), 20);
});

test('a session that is new counts with all its frames', () => {
  assert.equal(latency(status(session('1', 110, 10_000), session('2', 10, 30_000)), status(session('1', 100, 10_000))), 20);
});

test('who was answered nothing has no latency', () => {
  const same = status(session('1', 100, 10_000));
  assert.equal(latency(same, same), 0);
});
