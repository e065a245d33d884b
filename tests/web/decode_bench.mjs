// One line for each stream of cases: milliseconds that decoding a frame takes, in one worker and with LANES further ones,
// which are tried one after the other here: the longest lane of a frame, and what the first worker still does. See
// tests/web/decode_bench.
import { readFileSync } from 'node:fs';
import { Decoder, Lane } from '../../web/decoder.js';
import { Cases } from './cases.mjs';

const LANES = 4;
const module = await WebAssembly.compile(readFileSync(process.argv[2]));
const decoder = await Decoder.load(module);
const others = await Promise.all(Array.from({ length: LANES }, () => Decoder.load(module)));

const timed = (work) => {
  const start = performance.now();
  const result = work();
  return [result, performance.now() - start];
};
const median = (times) => times.slice(1).sort((a, b) => a - b)[(times.length - 1) >> 1].toFixed(2); // the first one compiles

/** Frames of a stream: their slices' bodies. */
function framesOf(cases, words) {
  const frames = [[]];
  for (let size = cases.u32(); size !== 0xffffffff; size = cases.u32()) {
    frames.at(-1).push(cases.raw(size));
    const whole = cases.u32() === 1;
    cases.u32();
    if (!whole) continue;
    cases.raw(4 * 7 + 4 * words);
    frames.push([]);
  }
  return frames.filter((bodies) => bodies.length > 0);
}

function alone(shape, frames) {
  const stream = decoder.stream(shape);
  const times = frames.map((bodies) => timed(() => bodies.forEach((body) => stream.slice(body)))[1]);
  stream.close();
  return median(times);
}

function withLanes(shape, frames) {
  const stream = decoder.stream(shape);
  const lanes = others.map((other) => new Lane(other, shape));
  const longest = [];
  const first = [];
  for (const bodies of frames) {
    const spent = lanes.map(() => 0);
    let own = 0;
    let whole = null;
    bodies.forEach((body, i) => {
      const [words, took] = timed(() => lanes[i % LANES].slice(body));
      spent[i % LANES] += took;
      const [frame, more] = timed(() => stream.isLongWork(body) && stream.put(body, words));
      own += more;
      whole = frame || whole;
    });
    if (!whole) throw new Error('lanes do not do what the native client does');
    lanes.forEach((lane, i) => (spent[i] += timed(() => lane.keep(whole.frame, whole.words))[1]));
    longest.push(Math.max(...spent));
    first.push(own);
  }
  for (const each of [stream, ...lanes]) each.close();
  return `${LANES} lanes ${median(longest)} ms each and ${median(first)} ms in the first worker`;
}

const cases = new Cases(readFileSync(0));
while (cases.left) {
  const shape = { width: cases.u32(), height: cases.u32(), lights: cases.u32() };
  const words = 2 * Math.ceil(shape.width / 8) * Math.ceil(shape.height / 8) * shape.lights;
  const frames = framesOf(cases, words);
  const isContext = frames[0][0][20] === 3; // the codec
  console.log(`WebAssembly ${alone(shape, frames)} ms${isContext ? `, ${withLanes(shape, frames)}` : ''}`);
}
