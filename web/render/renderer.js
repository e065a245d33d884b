// The renderer: the scene's own picture, shaded with the masks that arrive (gpu/picture/reference_view.h in a browser).
// Materials that blend are not drawn: packs leave their triangles out.
import { layersOf } from './accumulation.js';
import { contextOf, framebuffer, RenderError, texture2d } from './gl.js';
import { suggestExposure } from './exposure.js';
import { MOST_LIGHTS } from './lights.js';
import { outcomeOf } from './outcome.js';
import { Picture } from './picture.js';
import { Programs } from './programs.js';
import { Stage } from './stage.js';
import { warmUp } from './warm_up.js';
import { countsPoints, hardPlanes } from '../wire/planes.js';

export { RenderError };

/**
 * @typedef {import('./picture.js').Wish} Wish
 * @typedef {import('./masks.js').Masks} Masks
 * @typedef {import('./view.js').Camera} Camera
 * @typedef {import('./lights.js').Light} Light
 */

export class Renderer {
  /** Begins what takes long and needs no scene. Where pictures cannot be drawn, create() says so. */
  static async prepare(/** @type {HTMLCanvasElement} */ canvas) {
    try {
      const gl = contextOf(canvas);
      await warmUp(gl, Programs.of(gl));
    } catch (error) {
      if (!(error instanceof RenderError)) throw error;
    }
  }

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {import('../pack/pack.js').ScenePack} pack
   * @param {{antialias?: boolean}} [options] antialias: 2x2 samples a pixel; a wish may say otherwise
   * @throws {RenderError} with a sentence for people, where there is no WebGL2 or the scene is too large for the device
   */
  static async create(canvas, pack, options = {}) {
    const renderer = new Renderer(canvas, pack, options);
    await renderer.build();
    return renderer;
  }

  /** @private */
  constructor(
    /** @type {HTMLCanvasElement} */ canvas,
    /** @type {import('../pack/pack.js').ScenePack} */ pack,
    /** @type {{antialias?: boolean}} */ { antialias = false },
  ) {
    this.canvas = canvas;
    this.pack = pack;
    this.antialias = antialias;
    this.gl = contextOf(canvas);
    this.mostPlanes = this.gl.getParameter(this.gl.MAX_ARRAY_TEXTURE_LAYERS);
    /** @type {Stage | null} null while the context is lost */
    this.stage = null;
    /** @type {Picture | null} */
    this.picture = null;
    /** @type {Light[]} */
    this.lights = [];
    this.lightsVersion = 0;
    /** @type {Map<string, Masks>} the newest of each eye */
    this.masks = new Map();
    /** @type {Map<string, {texture: import('./gl.js').Texture, framebuffer: WebGLFramebuffer}>} what is drawn elsewhere */
    this.copies = new Map();
    /** @type {Wish | null} what was drawn last */
    this.wish = null;
    this.grid = { exact: false, subpixels: 0 };
    /** @type {() => void} called when a lost context has come back and pictures can be drawn again */
    this.onRestored = () => {};
    this.events = new AbortController();
    this.watchContext();
  }

  /** @private */
  async build() {
    const { gl } = this;
    const stage = await Stage.create(gl, this.pack);
    if (gl.isContextLost()) return;
    this.stage = stage;
    this.picture = new Picture(stage, this.pack.info.surroundings);
    this.grid = stage.programs.grid;
    this.copies.clear();
  }

  /** A device may take the context away and give it back: everything on it is then made again. @private */
  watchContext() {
    const options = { signal: this.events.signal };
    this.canvas.addEventListener(
      'webglcontextlost',
      (event) => {
        event.preventDefault();
        this.stage = this.picture = null;
      },
      options,
    );
    this.canvas.addEventListener(
      'webglcontextrestored',
      async () => {
        await this.build();
        if (this.stage) this.onRestored();
      },
      options,
    );
  }

  /** Whether the device has taken the context away for now: nothing is drawn until `onRestored`. */
  get lost() {
    return this.stage === null;
  }

  /** The lights of WIRE.md, at rest; those that animations move are moved to the picture's time. */
  setLights(/** @type {Light[]} */ lights, version = 0) {
    if (lights.length > MOST_LIGHTS) throw new RenderError(`At most ${MOST_LIGHTS} lights can be shown.`);
    this.lights = lights;
    this.lightsVersion = version;
  }

  /** The newest whole frame. A headset has two eyes, each with masks of its own; a screen has one, without a name. */
  takeMasks(/** @type {Masks} */ masks, eye = '') {
    this.masks.set(eye, masks);
  }

  /**
   * Draws a picture of the canvas's size or a part of it. With exact shadows the scene is shown at the time of the
   * masks, as they fit no other.
   * @param {Wish} wish
   * @returns {{predicted: boolean}} whether the masks are of another camera
   */
  draw(wish) {
    this.wish = wish;
    if (!this.stage) return { predicted: false };
    if (this.canvas.width !== wish.width || this.canvas.height !== wish.height) this.resize(wish.width, wish.height);
    return { predicted: this.paint(wish, { framebuffer: null, flipped: true }) };
  }

  /**
   * Draws a picture into a part of a framebuffer that somebody else owns, as that of a headset.
   * @param {Wish} wish
   * @param {{framebuffer: WebGLFramebuffer | null, x: number, y: number, width: number, height: number}} into
   */
  drawInto(wish, into) {
    if (!this.stage) return { predicted: false };
    const { gl } = this;
    const copy = this.copyOf(wish);
    const predicted = this.paint(wish, { framebuffer: copy.framebuffer, flipped: true });
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, copy.framebuffer);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, into.framebuffer);
    const [right, top] = [into.x + into.width, into.y + into.height];
    gl.blitFramebuffer(0, 0, wish.width, wish.height, into.x, into.y, right, top, gl.COLOR_BUFFER_BIT, gl.LINEAR);
    return { predicted };
  }

  /** Where the picture of an eye is drawn before it is copied. @private */
  copyOf(/** @type {Wish} */ { eye = '', width, height }) {
    const { gl } = this;
    let copy = this.copies.get(eye);
    if (!copy || copy.texture.width !== width || copy.texture.height !== height) {
      if (copy) this.dropCopy(copy);
      const texture = texture2d(gl, gl.RGBA8, width, height);
      copy = { texture, framebuffer: framebuffer(gl, texture, null) };
      this.copies.set(eye, copy);
    }
    return copy;
  }

  /** @private */
  dropCopy(/** @type {{texture: import('./gl.js').Texture, framebuffer: WebGLFramebuffer}} */ copy) {
    this.gl.deleteFramebuffer(copy.framebuffer);
    this.gl.deleteTexture(copy.texture.texture);
  }

  /** @private */
  paint(/** @type {Wish} */ given, /** @type {import('./picture.js').Output} */ output) {
    const stage = /** @type {Stage} */ (this.stage);
    const wish = { antialias: this.antialias, ...given };
    const asked = wish.split ? [wish.split.left, wish.split.right] : [wish.shadows ?? 'exact'];
    const masks = asked.includes('exact') ? this.masksOfLights(wish.eye ?? '') : null;
    const planes = masks?.planes ?? hardPlanes(this.lights.length);
    const gathered = masks ? (wish.gathered ?? null) : null;
    const accumulates = masks !== null && !gathered && Boolean(wish.accumulate) && countsPoints(planes);
    if (masks) this.upload(masks, wish.eye ?? '', accumulates);
    const own = accumulates ? layersOf(planes, stage.geometry.motion.lightNodes) : null;
    const layers = gathered?.layers ?? own;
    const time = masks ? masks.sceneTimeUs : (wish.sceneTimeUs ?? 0);
    const lights = this.pose(time, wish.lightsOn ?? null, asked.includes('maps'), planes, layers ?? []);
    const predicted = /** @type {Picture} */ (this.picture).draw(wish, masks, { count: lights.length, layers }, output);
    stage.timing.collect();
    return predicted;
  }

  /** @private */
  upload(/** @type {Masks} */ masks, /** @type {string} */ eye, /** @type {boolean} */ accumulates) {
    const stage = /** @type {Stage} */ (this.stage);
    if (accumulates) stage.accumulationOf(eye).take(masks);
    else stage.dropAccumulation(eye);
    stage.masksOf(eye).put(masks);
  }

  /** The newest masks of an eye, if they are of as many lights as there are. @private */
  masksOfLights(/** @type {string} */ eye) {
    const masks = this.masks.get(eye);
    if (!masks || this.lights.length === 0) return null;
    const planes = masks.planes ?? hardPlanes(this.lights.length);
    const words = 2 * Math.ceil(masks.width / 8) * Math.ceil(masks.height / 8) * planes.total;
    return planes.total <= this.mostPlanes && planes.first.length === this.lights.length && masks.words.length === words ? masks : null;
  }

  /**
   * Brings the scene and its lights to a time.
   * @param {number} time
   * @param {Uint8Array | null} on
   * @param {boolean} maps
   * @param {import('../wire/planes.js').Planes} planes of the masks
   * @param {number[]} shareLayers as Lights.put() takes them
   * @private
   */
  pose(time, on, maps, planes, shareLayers = []) {
    const stage = /** @type {Stage} */ (this.stage);
    const { geometry, raster } = stage;
    geometry.pose(time);
    const lights = geometry.motion.lightsAt(this.lights, time);
    const scene = geometry.surfacesMove ? `${time} ` : '';
    const layers = maps
      ? stage.maps.update(lights, scene, (camera, toClip) => raster.drawDepths(camera, toClip, stage.sceneUniforms))
      : [];
    stage.lights.put(lights, on, layers, planes, shareLayers);
    return lights;
  }

  /** See exposure.js. `camera` may be that of the masks or of the picture. */
  suggestExposure(/** @type {Camera} */ camera) {
    if (!this.stage) return 1;
    const lights = this.pose(0, null, false, hardPlanes(this.lights.length));
    return suggestExposure(this.stage, this.pack.info.surroundings, camera, lights.length);
  }

  /**
   * How wrong masks would have been as a prediction of later ones. `shown`: the part of the later view that counts.
   * @param {Masks} seen
   * @param {Masks} later
   * @param {Camera} camera of the later picture, without its border
   * @param {{width: number, height: number}} [size] of that picture; otherwise the canvas's
   * @returns {Promise<number | null>} share of wrong bits; null where nothing can be compared
   */
  async outcome(seen, later, camera, size = { width: this.canvas.width, height: this.canvas.height }) {
    if (!this.stage) return null;
    this.stage.geometry.pose(seen.sceneTimeUs);
    return outcomeOf(this.stage, seen, later, { camera, ...size });
  }

  /** The picture that was drawn last: RGBA, rows from the top. */
  readPixels() {
    const { gl, wish } = this;
    if (!wish || !this.stage) throw new RenderError('There is no picture to read.');
    const target = texture2d(gl, gl.RGBA8, wish.width, wish.height);
    const buffer = framebuffer(gl, target, null);
    this.paint(wish, { framebuffer: buffer, flipped: false });
    gl.bindFramebuffer(gl.FRAMEBUFFER, buffer);
    const pixels = new Uint8Array(4 * wish.width * wish.height);
    gl.readPixels(0, 0, wish.width, wish.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    gl.deleteFramebuffer(buffer);
    gl.deleteTexture(target.texture);
    return pixels;
  }

  /** Sets the size of the canvas in pixels. The picture is empty until the next draw. */
  resize(/** @type {number} */ width, /** @type {number} */ height) {
    this.canvas.width = width;
    this.canvas.height = height;
  }

  /** What the last pictures took: milliseconds of the device, where the browser tells. */
  get stats() {
    const ms = this.stage?.timing.ms ?? {};
    const accumulate = this.wish?.accumulate ? (ms.accumulate ?? 0) : 0;
    return {
      triangles: this.pack.triangleCount,
      rasterMs: ms.raster ?? null,
      shadeMs: ms.shade ?? null,
      gpuMs: ms.shade === undefined ? null : ms.shade + (ms.raster ?? 0) + accumulate,
    };
  }

  dispose() {
    this.events.abort();
    this.picture?.dispose();
    for (const copy of this.copies.values()) this.dropCopy(copy);
    this.stage?.dispose();
    this.stage = this.picture = null;
  }
}
