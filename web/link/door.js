// Where a page of a fleet goes on: under the scene's own name, by which the fleet's door sends those who ask for one scene
// to one server (protocol/WIRE.md, Fleets). A browser says in TLS the host that is in the address, and nothing else.
import { format } from '../ui/permalink.js';

const BYTES_SAID = 8; // of the hash of the scene's name
const NAMED = /^s-[0-9a-f]{16}\./;

/** @param {string} scene as Hello has it @param {string} fleet @returns {Promise<string>} */
export async function hostOf(scene, fleet) {
  const hash = new Uint8Array(await crypto.subtle.digest('SHA-256', new TextEncoder().encode(scene)));
  const digits = Array.from(hash.subarray(0, BYTES_SAID), (byte) => byte.toString(16).padStart(2, '0'));
  return `s-${digits.join('')}.${fleet}`;
}

/**
 * The address at which the page of this place goes on; null: here. A page that was reached past the door stays where it is.
 * A token is kept for one host alone: it goes along behind the #, and the page takes it out of the address there.
 * @param {import('../ui/permalink.js').Place} place
 * @param {{href: string, hostname: string}} location
 * @param {string} fleet empty: there is none
 * @returns {Promise<string | null>}
 */
export async function addressOf(place, location, fleet) {
  if (!fleet || !globalThis.crypto?.subtle) return null;
  if (location.hostname.replace(NAMED, '') !== fleet) return null;
  const host = await hostOf(place.scene, fleet);
  if (host === location.hostname) return null;
  const address = new URL(location.href);
  address.hostname = host;
  address.hash = format(place) + (place.token ? `&token=${encodeURIComponent(place.token)}` : '');
  return address.href;
}
