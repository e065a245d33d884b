// What a link to this page says: behind the #, so that no server and no log sees any of it.
//
//   #scene=temple&cam=x,y,z,yaw,pitch,fov[&soft=4|16][&occlusion=1|half][&filter=1][&accumulate=1]
//   [&tenant=NAME][&token=SECRET]
//
// A token is taken out of the address at once and kept for this tab alone.

const TOKEN_KEY = 'gnomon-token';
const DIGITS = 4;

/**
 * @typedef {object} Place
 * @property {string} scene empty: not said
 * @property {string} tenant
 * @property {string} token
 * @property {1 | 4 | 16} samples points of each area light
 * @property {import('../wire/planes.js').Occlusion} occlusion of ambient light
 * @property {boolean} filter of what is counted
 * @property {boolean} accumulate over masks
 * @property {{position: number[], yaw: number, pitch: number, verticalFov: number} | null} view radians
 */

/** @param {string | null} text */
function parseView(text) {
  const numbers = (text ?? '').split(',').map(Number);
  if (numbers.length !== 6 || numbers.some((number) => !Number.isFinite(number))) return null;
  const [x, y, z, yaw, pitch, fov] = numbers;
  if (Math.abs(pitch) > Math.PI / 2 || !(fov > 0.05 && fov < 3)) return null;
  return { position: [x, y, z], yaw, pitch, verticalFov: fov };
}

/** @param {string} hash of the address, with or without # @returns {Place} */
export function parse(hash) {
  const said = new URLSearchParams(hash.replace(/^#/, ''));
  return {
    scene: said.get('scene') ?? '',
    tenant: said.get('tenant') ?? '',
    token: said.get('token') ?? '',
    samples: /** @type {1 | 4 | 16} */ ([4, 16].find((samples) => said.get('soft') === String(samples)) ?? 1),
    occlusion: said.get('occlusion') === '1' ? 'full' : said.get('occlusion') === 'half' ? 'half' : 'none',
    filter: said.get('filter') === '1',
    accumulate: said.get('accumulate') === '1',
    view: parseView(said.get('cam')),
  };
}

/** The fragment that leads here; never with a token. @param {Place} place */
export function format(place) {
  const said = new URLSearchParams({ scene: place.scene });
  if (place.tenant) said.set('tenant', place.tenant);
  if (place.samples > 1) said.set('soft', String(place.samples));
  if (place.occlusion !== 'none') said.set('occlusion', place.occlusion === 'full' ? '1' : 'half');
  if (place.filter) said.set('filter', '1');
  if (place.accumulate) said.set('accumulate', '1');
  if (place.view) {
    const { position, yaw, pitch, verticalFov } = place.view;
    said.set('cam', [...position, yaw, pitch, verticalFov].map((part) => +part.toFixed(DIGITS)).join(','));
  }
  return '#' + said.toString().replaceAll('%2C', ',');
}

/**
 * What the address says. A token in it is moved to where only this tab finds it, and one that was moved before is found
 * again.
 * @param {Location} location @param {History} history @param {Storage} storage
 */
export function takeFromAddress(location, history, storage) {
  const place = parse(location.hash);
  if (place.token) {
    storage.setItem(TOKEN_KEY, place.token);
    history.replaceState(null, '', format({ ...place, token: '' }));
  }
  return { ...place, token: place.token || storage.getItem(TOKEN_KEY) || '' };
}
