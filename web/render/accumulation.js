// Accumulation of soft light: what is shown is the mean of the newest masks and up to three before them, whose pixels look
// at other points of a light wherever the camera has moved. Each mean is made anew of whole masks, so that nothing is seen
// longer than four of them. It is an estimate, as a shadow may have moved in between (shaders/accumulate.js has the rule).
import { fill, Target, textureArray } from './gl.js';
import { ACCUMULATE, ALIKE } from './shaders/accumulate.js';
import { findSources } from './sources.js';
import { OPEN_SEGMENTS } from '../wire/planes.js';

const MOST_EARLIER = 3;

/**
 * @typedef {import('./masks.js').Masks} Masks
 * @typedef {import('../wire/planes.js').Planes} Planes
 * @typedef {{texture: import('./masks.js').MaskTexture, target: import('./raster.js').IdTarget,
 *   view: import('./view.js').View}} Earlier masks on the device
 */

/**
 * Of each light the layer of its shares; -1 where its bits are taken as they are: it has no extent, or it moves.
 * @param {Planes} planes @param {Map<number, number>} moving
 */
export function layersOf({ samples }, moving) {
  let layer = 0;
  return samples.map((points, light) => (points > 1 && !moving.has(light) ? layer++ : -1));
}

/** Whether they may be averaged. @param {Masks} a @param {Masks} b */
function alike(a, b) {
  const shape = (/** @type {Masks} */ { width, height, planes }) => JSON.stringify([width, height, planes]);
  return a.session === b.session && a.lightsVersion === b.lightsVersion && shape(a) === shape(b);
}

export class Accumulation {
  constructor(/** @type {import('./stage.js').Stage} */ stage, /** @type {string} */ eye) {
    const { gl } = stage;
    this.stage = stage;
    this.eye = eye;
    /** @type {Masks | null} */
    this.newest = null;
    /** @type {import('./view.js').View | null} of the newest masks, once there are shares of them */
    this.view = null;
    /** @type {Earlier[]} the newest first */
    this.earlier = [];
    this.alike = new Target(gl, gl.R32UI);
    this.sources = Array.from({ length: MOST_EARLIER }, () => new Target(gl, gl.R32UI));
    /** @type {(import('./gl.js').Texture & {layers: number}) | null} */
    this.shares = null;
    this.framebuffer = gl.createFramebuffer();
  }

  /** Says which masks are about to be the eye's: those before are kept. */
  take(/** @type {Masks} */ masks) {
    const { newest, view, stage, eye } = this;
    if (masks === newest) return;
    this.newest = masks;
    this.view = null;
    const target = stage.targets.get(`seen ${eye}`),
      texture = stage.masks.get(eye);
    if (!newest || !view || !target || !texture || !alike(newest, masks)) return this.forget();
    this.earlier.unshift({ texture, target, view });
    stage.masks.delete(eye);
    stage.targets.delete(`seen ${eye}`);
    if (this.earlier.length <= MOST_EARLIER) return;
    const oldest = /** @type {Earlier} */ (this.earlier.pop());
    stage.masks.set(eye, oldest.texture); // its place is taken by the newest
    stage.targets.set(`seen ${eye}`, oldest.target);
  }

  /**
   * The shares of the masks that were taken last, a layer for each light that has one and one for the ambient light.
   * @param {import('./sources.js').Seen} seen the view of these masks
   * @param {number[]} layers of the lights
   */
  sharesOf(seen, layers) {
    const masks = /** @type {Masks} */ (this.newest);
    const planes = /** @type {Planes} */ (masks.planes);
    const ofLights = layers.filter((layer) => layer >= 0).length;
    const shares = this.sized(masks.width, masks.height, ofLights + 1);
    if (this.view) return shares;
    this.view = seen.view;
    this.stage.timing.measure('accumulate', () => {
      this.prepare(seen);
      layers.forEach((layer, light) => {
        if (layer >= 0) this.fill(layer, planes.first[light], planes.samples[light], false);
      });
      if (planes.occlusion >= 0) this.fill(ofLights, planes.occlusion, OPEN_SEGMENTS, planes.halved);
    });
    return shares;
  }

  /** What is the same for every light. @private */
  prepare(/** @type {import('./sources.js').Seen} */ seen) {
    const { stage } = this;
    const { gl } = stage;
    const { width, height } = seen.view;
    gl.bindVertexArray(stage.array);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.alike.sized(width, height).framebuffer);
    stage.programs.fullScreen('alike', () => ALIKE).use({ ...stage.sceneUniforms, ...seen.view, ids: seen.ids });
    fill(gl, width, height);
    this.earlier.forEach(({ target, view }, i) => {
      const into = this.sources[i].sized(width, height).framebuffer;
      findSources(stage, seen, { ids: target.ids, view }, { into, resting: stage.geometry.restingTriangles });
    });
  }

  /** @private */
  fill(
    /** @type {number} */ layer,
    /** @type {number} */ plane,
    /** @type {number} */ samples,
    /** @type {boolean} */ halved,
  ) {
    const { stage, shares, alike, sources, earlier } = this;
    const { gl } = stage;
    const masks = stage.masksOf(this.eye).texture;
    const before = Object.fromEntries(
      sources.flatMap((target, i) => [
        [`earlier_masks_${i}`, (earlier[i]?.texture ?? stage.masksOf(this.eye)).texture],
        [`sources_${i}`, (target.made ?? alike.made)?.texture],
      ]),
    );
    const uniforms = { masks, alike: alike.made?.texture, ...before, earlier: earlier.length };
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
    const { texture, width, height } = /** @type {import('./gl.js').Texture} */ (shares);
    gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, texture, 0, layer);
    stage.programs
      .fullScreen('accumulate', () => ACCUMULATE)
      .use({ ...uniforms, first_plane: plane, samples, halved });
    fill(gl, width, height);
  }

  /** @private */
  sized(/** @type {number} */ width, /** @type {number} */ height, /** @type {number} */ layers) {
    const { gl } = this.stage;
    const { shares } = this;
    if (shares && shares.width === width && shares.height === height && shares.layers === layers) return shares;
    if (shares) gl.deleteTexture(shares.texture);
    return (this.shares = textureArray(gl, gl.R8UI, width, height, layers));
  }

  /** @private */
  forget() {
    for (const { texture, target } of this.earlier) {
      texture.dispose();
      target.dispose();
    }
    this.earlier = [];
  }

  dispose() {
    const { gl } = this.stage;
    this.forget();
    for (const target of [this.alike, ...this.sources]) target.dispose();
    if (this.shares) gl.deleteTexture(this.shares.texture);
    gl.deleteFramebuffer(this.framebuffer);
  }
}
