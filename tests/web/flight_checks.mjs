// Runs in the page: flies what web_flight_inputs flew, with the page's own order, balance and renderer.
import { Eye } from '/eye.js';
import { ErrorBalance } from '/prediction/error_balance.js';
import { ShowOrder } from '/prediction/show_order.js';
import { shownPart, tracedHeight, tracedWidth } from '/prediction/border.js';
import { sourcesOf } from '/render/outcome.js';

/** An eye whose worker is this flight. */
function eyeOf(size) {
  const balance = new ErrorBalance({ size });
  return Object.assign(Object.create(Eye.prototype), {
    size,
    balance,
    order: new ShowOrder(balance),
    masks: null,
    trial: null,
    worker: { postMessage: () => {} },
    emit: () => {},
  });
}

/** @returns what each picture was, as flight.json has it of the native client */
export async function fly(renderer, inputs) {
  const plan = await (await fetch(`${inputs}/flight.json`)).json();
  const { size, stepMs, each, late, cameras } = plan;
  const eye = eyeOf(size);
  const masksOf = async (n) => ({
    index: n,
    camera: cameras[n],
    width: tracedWidth(size),
    height: tracedHeight(size),
    words: new Uint32Array(await (await fetch(`${inputs}/${n}.words`)).arrayBuffer()),
    sceneTimeUs: 0,
  });
  const { stage } = renderer;
  const shown = [];
  for (let tick = 0; tick < cameras.length; ++tick) {
    eye.look(cameras[tick], tick * stepMs);
    if (tick >= late && (tick - late) % each === 0) eye.on({ is: 'frame', ...(await masksOf(tick - late)) });
    const next = eye.order.next(tick * stepMs);
    if (!next) continue;
    await eye.judge(renderer);
    const part = { camera: shownPart(next.camera.camera, size), width: size.width, height: size.height };
    const { sources } = await sourcesOf(stage, eye.masks, part);
    const wrong = await renderer.outcome(eye.masks, await masksOf(next.camera.index), part.camera, size);
    const known = sources.reduce((count, source) => count + (source ? 1 : 0), 0) / sources.length;
    shown.push({ tick, camera: next.camera.index, seen: next.seen.index, known, wrong });
  }
  return { mine: shown, native: plan.shown };
}
