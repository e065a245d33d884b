// The same view four times: with hard shadows, with soft ones, with ambient occlusion as well, and by a reference that has
// all points which the pixels of a 4x4 block look at (render/gathering.js). Each is what the daemon traced for this view
// and nothing else; the sessions are opened one after the other, while that of the viewer rests.
import { Eye } from './eye.js';
import { layersOf } from './render/accumulation.js';
import { BLOCK, Gathering } from './render/gathering.js';
import { shownPart, viewOf } from './prediction/border.js';

const MOST_POINTS = 16; // of a light in one mask
const BORDER = 8; // pixels, at least BLOCK - 1
const AGAIN_MS = 3_000; // without an answer, a view is asked for once more
const CODEC = 'tiles_lz4';

/**
 * @typedef {import('./prediction/border.js').Pose} Pose
 * @typedef {{name: string, points: number, occlusion: boolean, views: number, gpuMs: number}} Told of one picture, as its
 *   masks say it: points of a light with an extent, whether the ambient light's occlusion is counted, of how many views
 *   it is the mean, and how long one of them took the device
 * @typedef {Told & {pixels: Uint8Array, draw: (context: CanvasRenderingContext2D) => void}} Side
 */

/** Of both pictures' bytes the root mean square difference. @param {Uint8Array} a @param {Uint8Array} b */
export function difference(a, b) {
  let sum = 0;
  for (let i = 0; i < a.length; i += 4) for (let c = 0; c < 3; ++c) sum += (a[i + c] - b[i + c]) ** 2;
  return Math.sqrt(sum / ((a.length / 4) * 3));
}

export class SideBySide {
  /** @param {import('./viewer.js').Viewer} viewer */
  constructor(viewer) {
    this.viewer = viewer;
    /** @type {Eye | null} */
    this.eye = null;
    /** @type {((event: any) => void)[]} who waits for the next event */
    this.waiting = [];
    this.closed = true;
  }

  /**
   * Makes the pictures, one by one. The viewer rests until close().
   * @param {Pose} pose
   * @param {(side: Side) => void} onSide
   * @throws {Error} where the server, or close(), ends it before the last one
   */
  async open(pose, onSide) {
    const { viewer } = this;
    if (!viewer.wanted || !viewer.renderer) throw new Error('there is no picture yet');
    this.closed = false;
    viewer.pause();
    this.eye ??= new Eye(viewer.base, (event) => this.waiting.splice(0).forEach((wake) => wake(event)));
    this.eye.setSize({ ...viewer.size, borderX: BORDER, borderY: BORDER });
    onSide(await this.once('hard shadows', pose, 1, 'none'));
    onSide(await this.once('soft shadows', pose, MOST_POINTS, 'none'));
    const all = await this.once('soft, with ambient occlusion', pose, MOST_POINTS, 'full');
    onSide(all);
    onSide(await this.reference(pose, all));
    this.eye.close();
  }

  close() {
    if (this.closed) return;
    this.closed = true;
    this.eye?.close();
    this.waiting.splice(0).forEach((wake) => wake({ is: 'closed', why: 'closed', againInMs: null }));
    this.viewer.goOn();
  }

  /** @private @returns {Promise<any>} the next event of the session */
  next() {
    return new Promise((wake) => this.waiting.push(wake));
  }

  /** @private @param {string} name @param {Pose} pose @param {number} samples @param {'none' | 'full'} occlusion */
  async once(name, pose, samples, occlusion) {
    const { viewer, eye } = this;
    if (!eye || !viewer.wanted) throw new Error('closed');
    eye.connect(viewer.wanted, { codec: CODEC, samples, occlusion });
    return this.side(name, await this.masksAt(pose, { left: 0, top: 0 }));
  }

  /** @private @param {Pose} pose @param {Told} all what the newest session counts */
  async reference(pose, all) {
    const { viewer, eye } = this;
    if (viewer.moves) throw new Error('things move in this scene, so that no two views of it are of one moment');
    const geometry = viewer.renderer?.stage?.geometry;
    if (!eye || !geometry) throw new Error('closed');
    /** @type {Gathering | null} */
    let gathering = null;
    let masks, place;
    for (let i = 0; i < BLOCK * BLOCK; ++i) {
      place = { left: i % BLOCK, top: Math.floor(i / BLOCK) };
      masks = await this.masksAt(pose, place);
      gathering ??= new Gathering(eye.size, masks.planes, layersOf(masks.planes, geometry.motion.lightNodes));
      if (JSON.stringify(masks.planes) !== JSON.stringify(gathering.planes))
        throw new Error(`the server went from ${all.points} points to fewer meanwhile`);
      gathering.add(masks, place);
    }
    const gathered = /** @type {Gathering} */ (gathering).shares(masks, /** @type {any} */ (place));
    const side = this.side('reference', masks, gathered);
    return { ...side, points: side.points * BLOCK * BLOCK, views: BLOCK * BLOCK };
  }

  /**
   * The masks of a view in which the picture lies there.
   * @private @param {Pose} pose @param {import('./render/gathering.js').Place} place
   */
  async masksAt(pose, place) {
    const eye = /** @type {Eye} */ (this.eye);
    const camera = viewOf(pose, eye.size, place);
    const ask = () => eye.look(camera, performance.now());
    ask();
    const first = eye.order.count - 1;
    const again = setInterval(ask, AGAIN_MS);
    try {
      for (;;) {
        const event = await this.next();
        if (this.closed) throw new Error('closed');
        if (event.is === 'frame' && event.index >= first) return event;
        if (event.is === 'closed' || event.is === 'failed') throw new Error(event.why);
        if (event.is === 'fits') throw new Error(event.text);
      }
    } finally {
      clearInterval(again);
    }
  }

  /** @private @param {string} name @param {any} masks @param {import('./render/gathering.js').Gathered} [gathered] @returns {Side} */
  side(name, masks, gathered) {
    const { viewer, eye } = this;
    const { renderer } = viewer;
    if (!eye || !renderer || renderer.lost) throw new Error('the device was lost');
    const { width, height } = eye.size;
    renderer.setLights(masks.lights, masks.lightsVersion);
    renderer.takeMasks(masks);
    viewer.taken = null; // the renderer has other masks than the viewer's
    const camera = shownPart(masks.camera, eye.size);
    viewer.exposure ??= renderer.suggestExposure(camera);
    const { exposure } = viewer;
    const { lightsOn } = viewer.picture;
    renderer.draw({ camera, width, height, sceneTimeUs: masks.sceneTimeUs, lightsOn, exposure, gathered });
    const pixels = renderer.readPixels();
    const image = new ImageData(new Uint8ClampedArray(pixels.buffer), width, height);
    const points = Math.max(...masks.planes.samples);
    const told = { name, points, occlusion: masks.planes.occlusion >= 0, views: 1, gpuMs: masks.gpuUs / 1000 };
    return { ...told, pixels, draw: (context) => context.putImageData(image, 0, 0) };
  }
}
