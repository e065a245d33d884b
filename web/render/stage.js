// Everything that lives as long as a context: the scene on the device, the passes and their targets.
import { Accumulation } from './accumulation.js';
import { Geometry } from './geometry.js';
import { Lights } from './lights.js';
import { MaskTexture } from './masks.js';
import { Materials } from './materials.js';
import { Programs } from './programs.js';
import { IdTarget, Raster } from './raster.js';
import { ShadowMaps } from './shadow_maps.js';
import { SharesTexture } from './shares_texture.js';
import { Timing } from './timing.js';
import { viewOf } from './view.js';

export class Stage {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {import('../pack/pack.js').ScenePack} pack
   */
  static async create(gl, pack) {
    const stage = new Stage(gl, pack);
    [stage.materials] = await Promise.all([Materials.create(gl, pack), stage.programs.ready()]);
    return stage;
  }

  /** @private */
  constructor(/** @type {WebGL2RenderingContext} */ gl, /** @type {import('../pack/pack.js').ScenePack} */ pack) {
    this.gl = gl;
    this.programs = Programs.of(gl);
    this.raster = new Raster(gl, pack, this.programs);
    this.geometry = new Geometry(gl, pack);
    this.materials = /** @type {Materials} */ (/** @type {unknown} */ (null)); // create() sets it
    this.lights = new Lights(gl, pack.info.bounds);
    /** @type {Map<string, MaskTexture>} of each eye */
    this.masks = new Map();
    /** @type {Map<string, Accumulation>} of each eye */
    this.accumulations = new Map();
    this.gathered = new SharesTexture(gl);
    this.maps = new ShadowMaps(gl, pack.info.bounds);
    this.timing = new Timing(gl);
    /** @type {Map<string, IdTarget>} */
    this.targets = new Map();
    this.array = gl.createVertexArray();
  }

  get sceneUniforms() {
    return { ...this.geometry.uniforms, ...this.materials.uniforms };
  }

  /** Where the masks of an eye are kept. */
  masksOf(eye = '') {
    let masks = this.masks.get(eye);
    if (!masks) this.masks.set(eye, (masks = new MaskTexture(this.gl)));
    return masks;
  }

  /** Where the shares of an eye's masks are averaged. */
  accumulationOf(eye = '') {
    let accumulation = this.accumulations.get(eye);
    if (!accumulation) this.accumulations.set(eye, (accumulation = new Accumulation(this, eye)));
    return accumulation;
  }

  dropAccumulation(eye = '') {
    this.accumulations.get(eye)?.dispose();
    this.accumulations.delete(eye);
  }

  /**
   * The ids of a view in the target of that name, drawn unless they are there already: exactly the server's, if masks
   * were `traced` for them. Moving surfaces are those of the geometry's time.
   * @param {string} name
   * @param {import('./view.js').Camera} camera
   * @param {number} width
   * @param {number} height
   * @param {boolean} traced
   */
  idsOf(name, camera, width, height, traced) {
    let target = this.targets.get(name);
    if (!target || target.width !== width || target.height !== height) {
      target?.dispose();
      target = new IdTarget(this.gl, width, height);
      this.targets.set(name, target);
    }
    const view = viewOf(camera, width, height, this.raster.reversedDepth);
    const shows = `${Object.values(view).join()} ${this.geometry.surfacesMove ? this.geometry.time : 0}`;
    if (target.shows !== shows) {
      target.shows = shows;
      this.timing.measure('raster', () =>
        this.raster.drawIds(/** @type {IdTarget} */ (target), view, this.sceneUniforms, traced),
      );
    }
    return { ids: target.ids, view };
  }

  /** Frees a target that is not needed for now. */
  dropTarget(/** @type {string} */ name) {
    this.targets.get(name)?.dispose();
    this.targets.delete(name);
  }

  dispose() {
    const { gl } = this;
    for (const target of this.targets.values()) target.dispose();
    for (const part of [this.raster, this.maps, this.gathered]) part.dispose();
    this.geometry.dispose(gl);
    this.materials.dispose(gl);
    gl.deleteTexture(this.lights.texture.texture);
    for (const part of [...this.masks.values(), ...this.accumulations.values()]) part.dispose();
    gl.deleteVertexArray(this.array);
  }
}
