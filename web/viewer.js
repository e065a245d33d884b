// The viewer: a pose in, a picture out. Holds the renderer and one eye; knows no button and no text of the page.
//
// Events: {is: ...} of link/client.js, and `progress`, `interrupted` (the scene is asked for again), `scene`, `picture`,
// `failed`.
import { Eye } from './eye.js';
import { again } from './link/again.js';
import { headersOf } from './link/headers.js';
import { centred, extrapolate, placeOf, towards, viewOf } from './prediction/border.js';
import { Renderer } from './render/renderer.js';
import { fetchPack, ScenePack } from './pack/pack.js';
import { borderOf, Quality } from './ui/quality.js';
import { equal } from './wire/camera.js';

const SETTLE_MS = 400; // after a change of size, before another session is opened
const REST_MS = 300; // without a new picture, before the last one is drawn with four samples a pixel
const STEPS_AHEAD = 4; // pictures by which the border goes before the turn

/**
 * @typedef {import('./eye.js').Shown} Shown
 * @typedef {import('./prediction/border.js').Pose} Pose
 * @typedef {import('./render/picture.js').Shadows} Shadows
 * @typedef {{shadows: Shadows, split: {at: number, left: Shadows, right: Shadows} | null, lightsOn: Uint8Array | null,
 *   codec: 'tiles_lz4' | 'tiles_context', samples: 1 | 4 | 16, occlusion: import('./wire/planes.js').Occlusion,
 *   filter: boolean, accumulate: boolean, smooth: boolean}} PictureOptions samples: points of each area light (soft
 *   shadows); occlusion: of ambient light; filter and accumulate: of what is counted, see Wish; smooth: with four
 *   samples a pixel at rest
 */

export class Viewer {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {(event: {is: string} & Record<string, any>) => void} emit
   */
  constructor(canvas, emit) {
    this.canvas = canvas;
    this.emit = emit;
    this.base = new URL('.', import.meta.url);
    this.quality = new Quality();
    /** @type {PictureOptions} */
    this.picture = {
      ...{ shadows: 'exact', split: null, lightsOn: null, codec: 'tiles_lz4', smooth: true },
      ...{ samples: 1, occlusion: 'none', filter: false, accumulate: false },
    };
    this.eye = new Eye(this.base, (event) => this.on(event));
    /** @type {import('./eye.js').Wanted | null} */
    this.wanted = null;
    /** @type {Renderer | null} */
    this.renderer = null;
    /** @type {any} */
    this.welcome = null;
    /** @type {import('./pack/pack.js').ScenePack | null} */
    this.pack = null;
    /** @type {any} the masks that the renderer has */
    this.taken = null;
    /** @type {Pose | null} */
    this.pose = null;
    this.changed = true; // the picture has to be drawn even if no camera is new
    /** @type {number | null} */
    this.exposure = null;
    this.resizeAt = Infinity;
    this.smoothAt = Infinity;
    this.paused = false; // while a headset shows its own pictures
    Renderer.prepare(canvas);
    this.setSize();
    new ResizeObserver(() => {
      this.resizeAt = performance.now() + SETTLE_MS;
    }).observe(canvas);
  }

  get size() {
    return this.eye.size;
  }
  get order() {
    return this.eye.order;
  }
  get masks() {
    return this.eye.masks;
  }
  get drawn() {
    return this.eye.drawn;
  }

  /** Opens a scene; what was open is closed. @param {import('./eye.js').Wanted} wanted */
  async open(wanted) {
    this.wanted = { ...wanted };
    this.pack = this.welcome = null;
    this.dropRenderer();
    this.eye.connect(wanted, this.picture);
    await this.loadScene('default');
  }

  /** @param {RequestCache} cache */
  async loadScene(cache) {
    const wanted = /** @type {import('./eye.js').Wanted} */ (this.wanted);
    const headers = headersOf(wanted);
    const isWanted = () => wanted === this.wanted;
    const onProgress = (/** @type {number} */ done, /** @type {number} */ total) =>
      this.emit({ is: 'progress', done, total });
    const ask = async () => {
      const where = await fetch(new URL(`scene/${encodeURIComponent(wanted.scene)}`, this.base), { headers, cache });
      if (!where.ok) throw new Error(`${(await where.text()).trim() || where.statusText} (${where.status})`);
      const { pack, bytes } = await where.json();
      return fetchPack(new URL(pack, this.base).href, { headers, bytes, onProgress });
    };
    try {
      const buffer = await again(ask, { isWanted, onLoss: () => this.emit({ is: 'interrupted' }) });
      if (!isWanted()) return;
      this.pack = new ScenePack(buffer);
      await this.makeRenderer();
    } catch (error) {
      if (wanted === this.wanted) this.fail(error);
    }
  }

  /** @param {unknown} error */
  fail(error) {
    const why = error instanceof Error ? error.message : String(error);
    this.emit({ is: 'failed', why: `the scene "${this.wanted?.scene}" cannot be had: ${why}` });
  }

  async makeRenderer() {
    const { pack } = this;
    if (!pack || !this.welcome) return;
    this.dropRenderer(); // before, as the device may have no room for two
    const renderer = await Renderer.create(this.canvas, pack);
    if (pack !== this.pack || !this.welcome) return renderer.dispose(); // another scene was opened meanwhile
    this.dropRenderer(); // a session that was opened again meanwhile may have made one too
    renderer.setLights(this.welcome.scene.lights, this.welcome.lightsVersion);
    renderer.onRestored = () => {
      this.changed = true;
    };
    this.exposure = this.taken = null;
    this.changed = true;
    this.renderer = renderer;
    this.emit({ is: 'scene', pack, welcome: this.welcome, grid: renderer.grid });
  }

  dropRenderer() {
    this.renderer?.dispose();
    this.renderer = null;
    this.eye.drawn = null;
  }

  /** Returns whether the size has changed. */
  setSize() {
    const box = this.canvas.getBoundingClientRect();
    const { width, height } = this.quality.size(box.width, box.height, window.devicePixelRatio || 1);
    const before = this.eye.size;
    if (before.width === width && before.height === height) return false;
    this.eye.setSize({ width, height, borderX: borderOf(width), borderY: borderOf(height) });
    return true;
  }

  /** @param {any} event */
  on(event) {
    if (event.is === 'open') {
      const sceneChanged = this.welcome && this.welcome.scene.contentHash !== event.scene.contentHash;
      this.welcome = event;
      if (this.pack && sceneChanged) this.loadScene('no-store');
      else if (this.renderer) this.renderer.setLights(event.scene.lights, event.lightsVersion);
      else this.makeRenderer().catch((error) => this.fail(error));
    }
    if (event.is === 'sceneChanged') {
      this.welcome = { ...this.welcome, scene: event.scene, samples: event.samples, areas: event.areas };
      this.loadScene('no-store');
    }
    // Newer masks of the camera that is shown: there is no other camera to show, and yet a picture to draw.
    if (event.is === 'frame' && event.index === this.taken?.index) this.changed = true;
    if (event.is === 'fits') return this.shrinkTo(event);
    this.emit(event);
  }

  /** The server has room for fewer pixels. @param {{width: number, text: string}} event */
  shrinkTo(event) {
    while (this.size.width + this.size.borderX > event.width && this.quality.coarser()) this.setSize();
    if (this.size.width + this.size.borderX > event.width) {
      return this.emit({ is: 'closed', why: event.text, againInMs: null });
    }
    this.emit({ is: 'fits', ...event });
    if (this.wanted) this.eye.connect(this.wanted, this.picture);
  }

  /** Whether pictures change by themselves. */
  get moves() {
    return this.pack !== null && this.pack.info.moving.nodes.length > 0;
  }

  /** Whether no masks are needed for the picture that is wanted. */
  get isLocal() {
    return this.picture.shadows !== 'exact' && !this.picture.split;
  }

  /**
   * A turn of the page's loop. Returns whether a picture was drawn.
   * @param {Pose} pose of now
   * @param {number} now milliseconds
   */
  frame(pose, now) {
    if (this.paused) return false;
    if (now >= this.resizeAt) {
      this.resizeAt = Infinity;
      if (this.setSize() && this.wanted) this.eye.connect(this.wanted, this.picture);
      this.changed = true;
    }
    this.look(pose, now);
    if (!this.renderer || this.renderer.lost) return false;
    const shown = this.nextShown(now);
    if (shown) this.draw(this.renderer, shown, now);
    else this.smooth(this.renderer, now);
    return shown !== null;
  }

  /** What to draw now; null if nothing else than is seen already. @param {number} now */
  nextShown(now) {
    const { plain, drawn, order } = this.eye;
    if (this.isLocal) return plain && (this.changed || plain.camera !== drawn?.camera) ? plain : null;
    return order.next(now) ?? (this.changed ? (drawn ?? plain) : null);
  }

  /**
   * @param {Pose} pose
   * @param {number} now
   */
  look(pose, now) {
    const { size, order } = this.eye;
    const place = this.pose ? towards(size, pose, extrapolate(this.pose, pose, STEPS_AHEAD)) : centred(size);
    this.pose = pose;
    const newest = order.newest;
    const resting = newest && equal(viewOf(pose, size, placeOf(newest.camera, size)), newest.camera);
    if (!resting || this.moves) this.eye.look(viewOf(pose, size, place), now, !this.isLocal);
  }

  /**
   * @param {Renderer} renderer
   * @param {Shown} shown
   * @param {number} now
   */
  draw(renderer, shown, now) {
    const began = performance.now();
    const { size } = this.eye;
    const masks = this.eye.masks ?? this.taken; // those of another size or session predict better than none
    if (masks && masks !== this.taken) {
      renderer.setLights(masks.lights, masks.lightsVersion);
      renderer.takeMasks(masks);
      this.taken = masks;
    }
    this.eye.judge(renderer);
    renderer.draw(this.wish(renderer, shown, masks));
    this.eye.drawn = shown;
    this.changed = false;
    this.smoothAt = now + REST_MS;
    this.emit({
      is: 'picture',
      predicted: shown.reprojected,
      hasMasks: masks !== null,
      ageMs: now - shown.camera.asked,
    });
    const took = renderer.stats.gpuMs ?? performance.now() - began;
    if (this.quality.drawn(took, now)) this.resizeAt = now;
  }

  /**
   * What the renderer is to draw.
   * @param {Renderer} renderer
   * @param {Shown} shown
   * @param {any} masks
   */
  wish(renderer, shown, masks) {
    const { width, height } = this.eye.size;
    const camera = this.eye.shownCamera(shown);
    this.exposure ??= renderer.suggestExposure(camera);
    const { split, lightsOn, filter, accumulate } = this.picture;
    return {
      camera,
      width,
      height,
      sceneTimeUs: masks?.sceneTimeUs ?? 0,
      lightsOn,
      filter,
      accumulate,
      shadows: masks || this.isLocal ? this.picture.shadows : /** @type {Shadows} */ ('none'),
      split: masks ? split : null,
      exposure: this.exposure,
    };
  }

  /**
   * Draws what rests once more with 2x2 samples a pixel, each with the bits of the pixel that it lies in.
   * @param {Renderer} renderer
   * @param {number} now
   */
  smooth(renderer, now) {
    const { drawn } = this.eye;
    if (now < this.smoothAt || !drawn || !this.picture.smooth) return;
    this.smoothAt = Infinity;
    renderer.draw({ ...this.wish(renderer, drawn, this.taken), antialias: true });
  }

  /** Changes how the picture is made; what is not named stays. @param {Partial<PictureOptions>} changes */
  set(changes) {
    const { codec, samples, occlusion } = this.picture;
    const { isLocal } = this;
    Object.assign(this.picture, changes);
    this.changed = true;
    const sameCounts = samples === this.picture.samples && occlusion === this.picture.occlusion;
    const sameMasks = codec === this.picture.codec && sameCounts;
    if (!sameCounts) this.eye.setSize(this.eye.size); // the view at rest is asked for again
    if (!sameMasks && this.wanted && !this.paused) this.eye.connect(this.wanted, this.picture);
    else if (isLocal && !this.isLocal) this.eye.lookAgain();
  }

  /** Ends the session for now; pictures stay as they are. */
  pause() {
    this.paused = true;
    this.eye.close();
  }

  goOn() {
    this.paused = false;
    this.changed = true;
    if (this.wanted) this.eye.connect(this.wanted, this.picture);
  }

  close() {
    this.eye.close();
    this.dropRenderer();
  }
}
