// How wrong a prediction was: masks seen before, looked up through the surface tests, against those that arrived later
// (client::ClientRenderer::outcome, client::compare_some). Only every fourth pixel of every fourth row is looked at.
import { framebuffer, texture2d } from './gl.js';
import { findSources } from './sources.js';
import { placeWithin } from './view.js';
import { hardPlanes, seenOf } from '../wire/planes.js';

const STEP = 4;

/**
 * A camera with pixels STEP times as wide, whose centres are those of every STEPth pixel.
 * @param {import('./view.js').Camera} camera
 * @param {number} width
 * @param {number} height
 */
function sparse(camera, width, height) {
  const columns = Math.ceil(width / STEP),
    rows = Math.ceil(height / STEP);
  const across = (camera.tanLeft + camera.tanRight) / width,
    upright = (camera.tanUp + camera.tanDown) / height;
  const before = (STEP - 1) / 2;
  return {
    columns,
    rows,
    camera: {
      ...camera,
      tanLeft: camera.tanLeft + before * across,
      tanRight: (STEP * columns - before) * across - camera.tanLeft,
      tanUp: camera.tanUp + before * upright,
      tanDown: (STEP * rows - before) * upright - camera.tanUp,
    },
  };
}

/** @typedef {{camera: import('./view.js').Camera, width: number, height: number}} Part of a view that is shown */

/**
 * For every STEPth pixel of every STEPth row of a picture: 1 + the pixel of the seen view with the same surface, 0: none.
 * @param {import('./stage.js').Stage} stage whose geometry stands at the seen masks' time
 * @param {import('./masks.js').Masks} seen
 * @param {Part} shown
 */
export async function sourcesOf(stage, seen, shown) {
  const { gl } = stage;
  const few = sparse(shown.camera, shown.width, shown.height);
  const seenView = stage.idsOf('outcome seen', seen.camera, seen.width, seen.height, true);
  const shownView = stage.idsOf('outcome', few.camera, few.columns, few.rows, true);
  const target = texture2d(gl, gl.R32UI, few.columns, few.rows);
  const buffer = framebuffer(gl, target, null);
  findSources(stage, shownView, seenView, { into: buffer });
  const sources = new Uint32Array(few.columns * few.rows);
  await readLater(gl, few.columns, few.rows, sources);
  gl.deleteFramebuffer(buffer);
  gl.deleteTexture(target.texture);
  return { sources, columns: few.columns };
}

/**
 * @param {import('./stage.js').Stage} stage as for sourcesOf()
 * @param {import('./masks.js').Masks} seen
 * @param {import('./masks.js').Masks} later
 * @param {Part} shown of the later view
 * @returns {Promise<number | null>} share of wrong bits, or of points wrongly counted; null: nothing can be compared
 */
export async function outcomeOf(stage, seen, later, shown) {
  const place = placeWithin(shown.camera, shown, later.camera, later);
  const samples = (/** @type {import('./masks.js').Masks} */ masks) => planesOfMasks(masks).samples.join();
  if (!place || samples(seen) !== samples(later)) return null;
  const { sources, columns } = await sourcesOf(stage, seen, shown);
  return wrongShare(seen, later, sources, columns, place);
}

/** Reads the bound framebuffer without holding the page up. */
async function readLater(
  /** @type {WebGL2RenderingContext} */ gl,
  /** @type {number} */ width,
  /** @type {number} */ height,
  /** @type {Uint32Array} */ into,
) {
  const pixels = gl.createBuffer();
  gl.bindBuffer(gl.PIXEL_PACK_BUFFER, pixels);
  gl.bufferData(gl.PIXEL_PACK_BUFFER, into.byteLength, gl.STREAM_READ);
  gl.readPixels(0, 0, width, height, gl.RED_INTEGER, gl.UNSIGNED_INT, 0);
  gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
  const fence = /** @type {WebGLSync} */ (gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0));
  gl.flush();
  while (gl.clientWaitSync(fence, 0, 0) === gl.TIMEOUT_EXPIRED) await new Promise((go) => setTimeout(go, 4));
  gl.deleteSync(fence);
  gl.bindBuffer(gl.PIXEL_PACK_BUFFER, pixels);
  gl.getBufferSubData(gl.PIXEL_PACK_BUFFER, 0, into);
  gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
  gl.deleteBuffer(pixels);
}

function tilesOf(/** @type {import('./masks.js').Masks} */ masks) {
  return Math.ceil(masks.width / 8) * Math.ceil(masks.height / 8);
}

function planesOfMasks(/** @type {import('./masks.js').Masks} */ masks) {
  return masks.planes ?? hardPlanes(masks.words.length / (2 * tilesOf(masks)));
}

function lit(
  /** @type {import('./masks.js').Masks} */ masks,
  /** @type {number} */ plane,
  /** @type {number} */ x,
  /** @type {number} */ y,
) {
  const tile = plane * tilesOf(masks) + (y >> 3) * Math.ceil(masks.width / 8) + (x >> 3);
  const bit = (y & 7) * 8 + (x & 7);
  return (masks.words[2 * tile + (bit >> 5)] >>> (bit & 31)) & 1;
}

/** Of pixels that have a source. @returns {number} */
export function wrongShare(
  /** @type {import('./masks.js').Masks} */ seen,
  /** @type {import('./masks.js').Masks} */ later,
  /** @type {Uint32Array} */ sources,
  /** @type {number} */ columns,
  /** @type {number[]} */ [left, top],
) {
  const planes = planesOfMasks(later);
  let points = 0,
    wrong = 0;
  sources.forEach((source, i) => {
    if (source === 0) return;
    const seenX = (source - 1) % seen.width,
      seenY = Math.floor((source - 1) / seen.width);
    const x = left + STEP * (i % columns),
      y = top + STEP * Math.floor(i / columns);
    for (let light = 0; light < planes.first.length; ++light) {
      const said = seenOf(planes, light, (plane) => lit(seen, plane, seenX, seenY));
      const is = seenOf(planes, light, (plane) => lit(later, plane, x, y));
      points += planes.samples[light];
      wrong += Math.abs(said - is);
    }
  });
  return points ? wrong / points : 0;
}
