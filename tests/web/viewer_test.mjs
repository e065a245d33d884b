// The viewer without a browser: its worker, canvas and renderers are none, and a renderer is made when the test says so.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Renderer } from '../../web/render/renderer.js';
import { Viewer } from '../../web/viewer.js';
import { Timers } from './timers.mjs';

const WANTED = { scene: 'temple', tenant: '', token: '' };
const POSE = { position: [0, 0, 0], orientation: [0, 0, 0, 1], verticalFov: 0.9 };
const lamp = (intensity) => ({ intensity });
const pack = () => ({ info: { moving: { nodes: [] } } });
const opened = (name, intensity = 1) => ({
  is: 'open',
  lightsVersion: 0,
  scene: { contentHash: name, lights: [lamp(intensity)] },
});

const settle = () => new Promise((resolve) => setImmediate(resolve));

/** A renderer that only remembers what it was told. */
function fakeRenderer(of) {
  return {
    of,
    stats: { gpuMs: 1 },
    drawn: 0,
    disposed: 0,
    lights: null,
    setLights(lights) {
      this.lights = lights;
    },
    takeMasks(masks) {
      this.masks = masks;
    },
    suggestExposure: () => 1,
    outcome: async () => null,
    draw() {
      this.drawn += 1;
    },
    dispose() {
      this.disposed += 1;
    },
  };
}

function world(t) {
  const posted = [];
  const events = [];
  const renderers = []; // in the order in which they were begun; each is there once made() is called
  let workers = 0;
  class Worker {
    constructor() {
      this.number = ++workers;
    }
    postMessage(message) {
      posted.push({ ...message, to: this.number });
    }
  }
  class ResizeObserver {
    observe() {}
  }
  const globals = { Worker, ResizeObserver, window: {}, navigator: {}, fetch: () => new Promise(() => {}) };
  const before = Object.keys(globals).map((name) => [name, Object.getOwnPropertyDescriptor(globalThis, name)]);
  const { create, prepare } = Renderer;
  t.after(() => {
    for (const [name, was] of before) was ? Object.defineProperty(globalThis, name, was) : delete globalThis[name];
    Object.assign(Renderer, { create, prepare });
  });
  for (const [name, value] of Object.entries(globals))
    Object.defineProperty(globalThis, name, { value, configurable: true, writable: true });
  Renderer.prepare = async () => {};
  Renderer.create = (_, of) => {
    const renderer = fakeRenderer(of);
    renderers.push(renderer);
    return new Promise((resolve, reject) => {
      renderer.made = async () => {
        resolve(renderer);
        await settle();
      };
      renderer.failed = async (why) => {
        reject(new Error(why));
        await settle();
      };
    });
  };
  const canvas = { getBoundingClientRect: () => ({ width: 640, height: 480 }) };
  const viewer = new Viewer(canvas, (event) => events.push(event));
  const tell = (data) => viewer.eye.worker.onmessage({ data });
  const scenes = () => events.filter((event) => event.is === 'scene');
  return { viewer, tell, posted, events, renderers, scenes };
}

/** A viewer whose scene has come; its renderer is begun with the session. */
function withScene(t) {
  const parts = world(t);
  parts.viewer.open(WANTED);
  parts.viewer.pack = pack();
  return parts;
}

test('a renderer that is made after another scene was opened is disposed of', async (t) => {
  const { viewer, tell, renderers, scenes } = withScene(t);
  tell(opened('temple'));
  viewer.open({ ...WANTED, scene: 'hall' });
  await renderers[0].made();
  assert.equal(renderers[0].disposed, 1);
  assert.equal(viewer.renderer, null);
  assert.equal(scenes().length, 0);
});

test('the lights of another scene are not those of a renderer that was made for the one before', async (t) => {
  const { viewer, tell, renderers, scenes } = withScene(t);
  tell(opened('temple'));
  viewer.open({ ...WANTED, scene: 'hall' });
  tell(opened('hall', 9));
  await renderers[0].made();
  assert.equal(renderers[0].lights, null);
  assert.equal(renderers[0].disposed, 1);
  viewer.pack = pack();
  viewer.makeRenderer();
  await renderers[1].made();
  assert.equal(viewer.renderer, renderers[1]);
  assert.equal(renderers[1].of, viewer.pack);
  assert.deepEqual(renderers[1].lights, [lamp(9)]);
  assert.equal(scenes().length, 1);
});

test('a worker whose modules did not come is started again, and opens what was wanted', (t) => {
  const timers = new Timers();
  t.after(() => timers.restore());
  const { viewer, posted, events } = world(t);
  viewer.open(WANTED);
  viewer.eye.worker.onerror({});
  const { againInMs } = events.find((event) => event.is === 'closed');
  assert.equal(posted.length, 1);
  timers.pass(againInMs);
  assert.deepEqual(posted[1], { ...posted[0], to: 2 });
  viewer.eye.worker.onerror({ message: 'x is not defined' });
  assert.equal(events.at(-1).is, 'failed');
  timers.pass(100_000);
  assert.equal(posted.length, 2, 'an error in a module would come again');
});

test('a scene that changed before its renderer was made is loaded anew', async (t) => {
  const { viewer, tell, renderers } = withScene(t);
  tell(opened('temple'));
  const asked = [];
  viewer.loadScene = async (cache) => void asked.push(cache);
  tell(opened('temple, rebuilt'));
  assert.deepEqual(asked, ['no-store']);
  assert.equal(renderers.length, 1, 'none is made of the pack of before');
});

test('a renderer that cannot be made is said to be missing', async (t) => {
  const { tell, events, renderers } = withScene(t);
  tell(opened('temple'));
  await renderers[0].failed('no WebGL');
  assert.match(events.find((event) => event.is === 'failed').why, /temple.*no WebGL/);
});

for (const order of [
  [0, 1],
  [1, 0],
]) {
  test(`of two renderers of one scene one stays, made in the order ${order}`, async (t) => {
    const { viewer, tell, renderers } = withScene(t);
    tell(opened('temple', 1));
    tell(opened('temple', 2)); // the session was lost and opened again
    for (const each of order) await renderers[each].made();
    const [first, last] = order.map((each) => renderers[each]);
    assert.equal(viewer.renderer, last);
    assert.deepEqual([first.disposed, last.disposed], [1, 0]);
    assert.deepEqual(last.lights, [lamp(2)]);
  });
}

test('newer masks of a view at rest are drawn, those of older views are not', async (t) => {
  const { viewer, tell, posted, renderers } = withScene(t);
  tell(opened('temple'));
  await renderers[0].made();
  const [renderer] = renderers;
  const turned = { ...POSE, orientation: [0, Math.SQRT1_2, 0, Math.SQRT1_2] };
  let now = 0;
  const turn = (pose) => viewer.frame(pose, (now += 16));
  turn(POSE);
  turn(turned);
  const [older, newer] = posted.filter((message) => message.do === 'look');
  const frame = ({ index, camera }, intensity) =>
    tell({ is: 'frame', index, camera, lights: [lamp(intensity)], lightsVersion: intensity, width: 8, height: 8 });
  frame(newer, 1);
  assert.ok(turn(turned));
  assert.ok(!turn(turned), 'nothing is new');
  const before = renderer.drawn;
  frame(newer, 2);
  assert.ok(turn(turned));
  assert.equal(renderer.drawn, before + 1);
  assert.deepEqual(renderer.lights, [lamp(2)]);
  assert.equal(renderer.masks.lightsVersion, 2);
  assert.ok(!turn(turned));
  frame(older, 3);
  assert.ok(!turn(turned));
  assert.deepEqual(renderer.lights, [lamp(2)]);
});
