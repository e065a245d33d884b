// Under which host a page of a fleet goes on.
import assert from 'node:assert/strict';
import { webcrypto } from 'node:crypto';
import { test } from 'node:test';
import { addressOf, hostOf } from '../../web/link/door.js';
import { takeFromAddress } from '../../web/ui/permalink.js';

globalThis.crypto ??= webcrypto; // which Node 18 of Debian 12 has, though not as browsers do

const FLEET = 'gnomon.example';
const TEMPLE = 's-67425801bf1a60fe.gnomon.example'; // of protocol/WIRE.md
const HARD = { samples: 1, occlusion: 'none', filter: false, accumulate: false };
const place = (more) => ({ scene: 'temple', tenant: '', token: '', ...HARD, view: null, ...more });
const at = (href) => ({ href, hostname: new URL(href).hostname });

test('a scene has the name by which native clients ask the door', async () => {
  assert.equal(await hostOf('temple', FLEET), TEMPLE);
  // printf 'Höhle' | sha256sum
  assert.equal(await hostOf('Höhle', FLEET), 's-fdfa5de1ca148009.gnomon.example');
});

test('a page of the fleet goes on under the name of its scene, and stays there', async () => {
  const address = await addressOf(place({}), at('https://gnomon.example:7600/#scene=temple'), FLEET);
  assert.equal(address, `https://${TEMPLE}:7600/#scene=temple`);
  assert.equal(await addressOf(place({}), at(address), FLEET), null);
});

test('from one scene it goes on to another', async () => {
  const address = await addressOf(place({ scene: 'attic' }), at(`https://${TEMPLE}/viewer/#scene=attic`), FLEET);
  assert.equal(address, `https://${await hostOf('attic', FLEET)}/viewer/#scene=attic`);
});

test('what a link says goes along, and the token is taken out of the address at once', async () => {
  const view = { position: [1, 2, 3], yaw: 0.5, pitch: 0.25, verticalFov: 0.9 };
  for (const occlusion of ['none', 'half', 'full']) {
    const soft = { samples: 4, occlusion, filter: occlusion === 'half', accumulate: occlusion !== 'half' };
    const said = place({ scene: 'halls & more', tenant: 'studio', token: 's&cr=t#', ...soft, view });
    const address = await addressOf(said, at('https://gnomon.example/'), FLEET);
    const kept = new Map();
    const storage = { setItem: (key, value) => kept.set(key, value), getItem: (key) => kept.get(key) ?? null };
    let shown = '';
    const history = { replaceState: (state, title, hash) => (shown = hash) };
    assert.deepEqual(takeFromAddress(new URL(address), history, storage), said);
    assert.ok(shown.includes('tenant=studio') && !shown.includes('token'), shown);
  }
});

test('a page that was reached past the door stays where it is', async () => {
  for (const href of ['https://node7:7600/', 'https://10.0.0.11/', 'https://www.gnomon.example/', 'https://example/'])
    assert.equal(await addressOf(place({}), at(href), FLEET), null, href);
  assert.equal(await addressOf(place({}), at('https://gnomon.example/'), ''), null, 'no fleet');
});
