// The worker of the page: owns the connection and decodes masks, so that neither waits for a picture.
//
// From the page: {do: 'open', url, hello, processors}, {do: 'look', index, camera}, {do: 'close', reason}. To the page:
// the events of link/client.js, and {is: 'failed', why} if the decoder cannot be had.
import { Decoder } from './decoder.js';
import { again } from './link/again.js';
import { Client } from './link/client.js';
import { Lanes, lanesFor } from './link/lanes.js';

const post = (event, transfer = []) => self.postMessage(event, { transfer });

async function fetchDecoder() {
  const answer = await fetch(new URL('./wasm/decoder.wasm', import.meta.url));
  if (!answer.ok) throw new Error('this server was built without the decoder for browsers');
  return answer.arrayBuffer();
}

let processors = 1;

/** @param {Decoder} decoder */
function lanesOf({ module }) {
  const count = lanesFor(processors);
  const spawn = () => new Worker(new URL('./lane.js', import.meta.url), { type: 'module' });
  return count > 0 ? new Lanes({ count, spawn, module }) : null;
}

/** @type {Promise<Client>} */
const client = again(fetchDecoder).then(Decoder.load).then(
  (decoder) =>
    new Client({
      connect: (url) => new WebSocket(url, 'gnomon'),
      dial: 'WebTransport' in self ? (url, options) => new /** @type {any} */ (self).WebTransport(url, options) : null,
      decoder,
      lanes: () => lanesOf(decoder),
      emit: post,
      now: () => performance.now(),
    }),
);
client.catch((error) => post({ is: 'failed', why: error.message }));

self.onmessage = async ({ data }) => {
  const to = await client;
  if (data.do === 'open') {
    processors = data.processors;
    to.open(data.url, data.hello);
  }
  if (data.do === 'look') to.look(data.index, data.camera);
  if (data.do === 'close') to.close(data.reason);
};
