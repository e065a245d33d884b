// A worker that decodes slices for that of the session: link/lanes.js.
//
// To it: {do: 'load', module}, {do: 'open', shape}, {do: 'slice', id, body}, {do: 'keep', frame, words}, in this order.
// From it: {id, words}; words null: the slice cannot be decoded here.
import { Decoder, Lane } from './decoder.js';

/** @type {Decoder} */
let decoder;
/** @type {Lane | null} */
let lane = null;

/** @param {any} data */
async function on(data) {
  if (data.do === 'load') decoder = await Decoder.load(data.module);
  if (data.do === 'open') {
    lane?.close();
    lane = new Lane(decoder, data.shape);
  }
  if (data.do === 'keep') lane?.keep(data.frame, data.words);
  if (data.do === 'slice') {
    const words = lane?.slice(data.body) ?? null;
    self.postMessage({ id: data.id, words }, { transfer: words ? [words.buffer] : [] });
  }
}

let before = Promise.resolve();
self.onmessage = ({ data }) => {
  before = before.then(() => on(data)); // loading takes a while, and what comes meanwhile waits
};
