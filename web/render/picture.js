// Draws a picture: ids of what is seen, then a full-screen pass that shades them; with antialiasing 2x2 samples a pixel,
// as gpu::Reprojection::shade.
import { fill, Target } from './gl.js';
import { LOOKUPS, VIEWS } from './shaders/shade.js';
import { findSources } from './sources.js';
import { countsPoints } from '../wire/planes.js';
import { placeWithin, sameEye, seenUniforms } from './view.js';

/**
 * @typedef {import('./view.js').Camera} Camera
 * @typedef {'exact' | 'none' | 'maps'} Shadows
 * @typedef {{camera: Camera, width: number, height: number, sceneTimeUs?: number, lightsOn?: Uint8Array | null,
 *   shadows?: Shadows, split?: {at: number, left: Shadows, right: Shadows} | null, exposure?: number,
 *   ambient?: number | number[], tonemap?: 'filmic' | 'clamp', view?: 'shaded' | 'material' | 'normals',
 *   onlyLight?: number, antialias?: boolean, filter?: boolean, accumulate?: boolean,
 *   gathered?: import('./gathering.js').Gathered, eye?: string}} Wish what to draw;
 *   `view` and `onlyLight` are for tests; filter: what is counted is averaged over the pixels around that show the same
 *   surface, accumulate: over the masks before, both estimates; gathered: shares that stand for those of the masks
 * @typedef {{framebuffer: WebGLFramebuffer | null, flipped: boolean}} Output where to
 */

/** The uniforms that say how radiance becomes a picture: gpu::ShadingUniforms. */
export function shadingUniforms(
  /** @type {any} */ surroundings,
  /** @type {{ambient?: number | number[], exposure?: number, tonemap?: string,
   * view?: string, onlyLight?: number}} */ {
    ambient = 0,
    exposure = 1,
    tonemap = 'filmic',
    view = 'shaded',
    onlyLight = -1,
  },
) {
  const more = typeof ambient === 'number' ? [ambient, ambient, ambient] : ambient;
  const withMore = (/** @type {number[]} */ own) => own.map((value, i) => Math.fround(value + more[i]));
  return {
    ambient_above: withMore(surroundings.ambient_above),
    ambient_below: withMore(surroundings.ambient_below),
    has_sky: surroundings.has_sky,
    sky_zenith: surroundings.sky_zenith,
    sky_horizon: surroundings.sky_horizon,
    sky_ground: surroundings.sky_ground,
    sky_clouds: surroundings.sky_clouds,
    background: [0, 0, 0],
    exposure,
    tonemap_filmic: tonemap === 'filmic',
    view: VIEWS[/** @type {keyof typeof VIEWS} */ (view)],
    only_light: onlyLight,
  };
}

export class Picture {
  constructor(/** @type {import('./stage.js').Stage} */ stage, /** @type {any} */ surroundings) {
    this.stage = stage;
    this.surroundings = surroundings;
    this.samples = new Target(stage.gl, stage.gl.RGBA8);
    this.sources = new Target(stage.gl, stage.gl.R32UI);
  }

  /**
   * @param {Wish} wish
   * @param {import('./masks.js').Masks | null} masks that fit the lights; already on the device
   * @param {{count: number, layers: number[] | null}} lights layers: of their accumulated shares; null: there are none
   * @param {Output} output of the wish's size
   * @returns {boolean} whether masks of another camera were used
   */
  draw(wish, masks, lights, output) {
    const each = wish.antialias ? 2 : 1;
    const width = each * wish.width,
      height = each * wish.height;
    const place = masks && !wish.antialias ? placeWithin(wish.camera, wish, masks.camera, masks) : null;
    const halves = halvesOf(wish, width);
    const exact = halves.some((half) => half.shadows === 'exact') && masks !== null;
    const direct = exact && place !== null;
    const { stage } = this;
    const shared = this.shared(wish, masks, lights.count, exact);
    const shown =
      masks && direct
        ? this.seenIds(wish, masks)
        : this.stage.idsOf(`shown ${wish.eye ?? ''}`, wish.camera, width, height, false);
    const window = masks !== null && exact && looksAround(wish, masks);
    const shares = masks && exact && lights.layers ? this.sharesOf(wish, masks, lights.layers) : null;
    const into = wish.antialias ? this.samplesOf(width, height) : output;
    stage.timing.measure('shade', () => {
      const sources = masks && window && !direct ? this.found(wish, masks, shown) : null;
      for (const half of halves) {
        const masked = half.shadows === 'exact' && exact;
        const lookup = half.shadows === 'maps' ? LOOKUPS.MAPS : masked && !direct ? LOOKUPS.SEEN : LOOKUPS.MASKS;
        const first = place && direct ? place : [0, 0];
        const program = stage.programs.shade(lookup, { window: window && masked, shares: shares !== null && masked });
        const { ids, view } = shown;
        const uniforms = { ...shared, ...shares, ...view, ids, masked, first_pixel: first, window_step: each, sources };
        this.shade(program, half, width, height, into, uniforms);
      }
    });
    if (wish.antialias) this.average(wish, output);
    return exact && !direct && !(wish.antialias && masks !== null && sameEye(wish.camera, masks.camera));
  }

  /** Uniforms of all halves. @private */
  shared(
    /** @type {Wish} */ wish,
    /** @type {import('./masks.js').Masks | null} */ masks,
    /** @type {number} */ lightCount,
    /** @type {boolean} */ exact,
  ) {
    const { stage } = this;
    return {
      ...stage.sceneUniforms,
      ...stage.maps.uniforms,
      ...shadingUniforms(this.surroundings, wish),
      masks: stage.masksOf(wish.eye).texture,
      occlusion_plane: masks?.planes?.occlusion ?? -1,
      halved: masks?.planes?.halved ?? false,
      filtered: wish.filter ?? false,
      ...(masks && exact ? this.seen(wish, masks) : {}),
      lights: stage.lights.texture,
      light_count: lightCount,
    };
  }

  /** The view of the masks. Its ids are drawn only where they are looked up. @private */
  seen(/** @type {Wish} */ wish, /** @type {import('./masks.js').Masks} */ masks) {
    const { ids, view } = this.seenIds(wish, masks);
    const eye = Boolean(wish.antialias) && sameEye(wish.camera, masks.camera);
    return { ...seenUniforms(view), seen_ids: ids, same_eye: eye };
  }

  /** @private */
  seenIds(/** @type {Wish} */ { eye = '' }, /** @type {import('./masks.js').Masks} */ masks) {
    return this.stage.idsOf(`seen ${eye}`, masks.camera, masks.width, masks.height, true);
  }

  /** Instead of what the masks alone count. @private */
  sharesOf(
    /** @type {Wish} */ wish,
    /** @type {import('./masks.js').Masks} */ masks,
    /** @type {number[]} */ layers,
  ) {
    const { stage } = this;
    const shares = wish.gathered
      ? stage.gathered.put(wish.gathered)
      : stage.accumulationOf(wish.eye).sharesOf(this.seenIds(wish, masks), layers);
    return { shares, occlusion_layer: shares.layers - 1 };
  }

  /** Where each pixel of the shown view finds its masks. @private */
  found(
    /** @type {Wish} */ wish,
    /** @type {import('./masks.js').Masks} */ masks,
    /** @type {import('./sources.js').Seen} */ shown,
  ) {
    const { texture, framebuffer } = this.sources.sized(shown.view.width, shown.view.height);
    const eye = Boolean(wish.antialias) && sameEye(wish.camera, masks.camera);
    const seen = this.seenIds(wish, masks); // they are there: see seen()
    findSources(this.stage, shown, seen, { into: framebuffer, sameEye: eye });
    return texture;
  }

  /** @private */
  shade(
    /** @type {import('./gl.js').Program} */ program,
    /** @type {{from: number, to: number}} */ half,
    /** @type {number} */ width,
    /** @type {number} */ height,
    /** @type {Output} */ into,
    /** @type {Record<string, any>} */ uniforms,
  ) {
    const { gl, array } = this.stage;
    gl.bindFramebuffer(gl.FRAMEBUFFER, into.framebuffer);
    gl.bindVertexArray(array);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(half.from, 0, half.to - half.from, height);
    program.use({ ...uniforms, flipped_height: into.flipped ? height : 0 });
    fill(gl, width, height);
    gl.disable(gl.SCISSOR_TEST);
  }

  /** @private */
  average(/** @type {Wish} */ wish, /** @type {Output} */ output) {
    const { gl, array } = this.stage;
    gl.bindFramebuffer(gl.FRAMEBUFFER, output.framebuffer);
    gl.bindVertexArray(array);
    this.stage.programs
      .average()
      .use({ samples: this.samples.made?.texture, flipped_height: output.flipped ? wish.height : 0 });
    fill(gl, wish.width, wish.height);
  }

  /** @private */
  samplesOf(/** @type {number} */ width, /** @type {number} */ height) {
    return { framebuffer: this.samples.sized(width, height).framebuffer, flipped: false };
  }

  dispose() {
    this.samples.dispose();
    this.sources.dispose();
  }
}

/** Whether what is counted at pixels around has a say. */
function looksAround(/** @type {Wish} */ { filter }, /** @type {import('./masks.js').Masks} */ { planes }) {
  return planes !== undefined && (planes.halved || Boolean(filter && countsPoints(planes)));
}

/** @returns {{shadows: Shadows, from: number, to: number}[]} columns of samples */
function halvesOf(/** @type {Wish} */ wish, /** @type {number} */ width) {
  const { split, shadows = 'exact' } = wish;
  if (!split) return [{ shadows, from: 0, to: width }];
  const middle = Math.max(0, Math.min(width, Math.round(split.at * width)));
  return [
    { shadows: split.left, from: 0, to: middle },
    { shadows: split.right, from: middle, to: width },
  ].filter((half) => half.to > half.from);
}
