// The viewer in a headset, by WebXR: two eyes, each with a session of its own, drawn by one renderer.
//
// The device says where each eye is and what it sees, as a frustum with four tangents, which is what the wire carries.
// Unequal ages of the two eyes' masks do no harm, as each eye predicts from its own.
import { Eye, MOST_RATE_HZ } from './eye.js';
import { add, multiply, normalized, rotate } from './prediction/vector.js';
import { centred } from './prediction/border.js';
import { rounded } from './wire/camera.js';
import { borderOf } from './ui/quality.js';

const ALIGN = 8; // sizes are whole tiles
const LEAST_SIDE = 64,
  MOST_SIDE = 2048; // pixels of an eye
const LEAST_RATE_HZ = 10;
const OVER_CAPACITY = 9; // a code of Refused
const COARSER = 0.75; // of the pixels each way, where the server has no room for more
const NEAR = 0.05; // metres

/**
 * The four tangents of a frustum, of a projection matrix column by column.
 * @param {ArrayLike<number>} p
 */
export function tangentsOf(p) {
  return {
    tanLeft: (1 - p[8]) / p[0],
    tanRight: (1 + p[8]) / p[0],
    tanUp: (1 + p[9]) / p[5],
    tanDown: (1 - p[9]) / p[5],
  };
}

/**
 * The camera of a buffer with a border around what is shown.
 * @param {import('./wire/camera.js').Camera} shown
 * @param {import('./prediction/border.js').ViewSize} size
 */
export function withBorder(shown, size) {
  const place = centred(size);
  const across = (shown.tanLeft + shown.tanRight) / size.width;
  const down = (shown.tanUp + shown.tanDown) / size.height;
  return rounded({
    ...shown,
    tanLeft: shown.tanLeft + across * place.left,
    tanRight: shown.tanRight + across * (size.borderX - place.left),
    tanUp: shown.tanUp + down * place.top,
    tanDown: shown.tanDown + down * (size.borderY - place.top),
  });
}

export class Headset {
  /**
   * @param {import('./viewer.js').Viewer} viewer whose scene is open
   * @param {import('./ui/gaze.js').Gaze} gaze where the person stands; the headset moves about it
   * @param {(text: string) => void} tell
   */
  constructor(viewer, gaze, tell) {
    this.viewer = viewer;
    this.gaze = gaze;
    this.tell = tell;
    this.scale = 1; // of the device's own pixels
    this.rateHz = MOST_RATE_HZ; // of each eye
    /** @type {Map<string, Eye>} by the name of the view */
    this.eyes = new Map();
    /** @type {any} */
    this.session = null;
  }

  /** Enters; resolves when the headset is left. */
  async enter() {
    const { renderer } = this.viewer;
    if (!renderer) return;
    const gl = /** @type {any} */ (renderer.gl);
    const session = await /** @type {any} */ (navigator).xr.requestSession('immersive-vr');
    this.session = session;
    this.viewer.pause(); // what the two eyes see is what the server is to have room for
    try {
      await this.show(session, gl);
    } catch (error) {
      await session.end().catch(() => {});
      throw error;
    } finally {
      for (const eye of this.eyes.values()) eye.close();
      this.eyes.clear();
      this.session = null;
      this.viewer.goOn();
    }
  }

  /**
   * Shows what the headset sees; resolves when it is left.
   * @param {any} session
   * @param {any} gl
   */
  async show(session, gl) {
    await gl.makeXRCompatible();
    const layer = new /** @type {any} */ (globalThis).XRWebGLLayer(session, gl, {
      alpha: false,
      antialias: false,
      depth: false,
    });
    session.updateRenderState({ baseLayer: layer });
    const space = await session.requestReferenceSpace('local');
    const left = new Promise((resolve) => session.addEventListener('end', resolve, { once: true }));
    const turn = (/** @type {number} */ time, /** @type {any} */ frame) => {
      session.requestAnimationFrame(turn);
      const pose = frame.getViewerPose(space);
      if (pose) for (const view of pose.views) this.drawEye(view, layer, performance.now());
    };
    session.requestAnimationFrame(turn);
    await left;
  }

  /**
   * The eye of a view, with a session for its size.
   * @param {string} name
   * @param {{width: number, height: number}} viewport
   */
  eyeOf(name, viewport) {
    const side = (/** @type {number} */ length) =>
      Math.min(MOST_SIDE, Math.max(LEAST_SIDE, Math.floor((length * this.scale) / ALIGN) * ALIGN));
    const [width, height] = [side(viewport.width), side(viewport.height)];
    let eye = this.eyes.get(name);
    if (!eye) {
      const on = (/** @type {any} */ event) => {
        if (event.is === 'fits') this.scale *= COARSER;
        if (event.is === 'closed' && event.refusal?.code === OVER_CAPACITY) this.share();
        if (event.is === 'closed' || event.is === 'failed') this.tell(event.why);
        if (event.is === 'open') this.tell('');
      };
      eye = new Eye(this.viewer.base, on, 1 / 2);
      this.eyes.set(name, eye);
    }
    if (eye.size.width !== width || eye.size.height !== height) {
      eye.setSize({ width, height, borderX: borderOf(width), borderY: borderOf(height) });
      this.connect(eye);
    }
    return eye;
  }

  /** @param {Eye} eye */
  connect(eye) {
    if (this.viewer.wanted) eye.connect(this.viewer.wanted, this.viewer.picture, this.rateHz);
  }

  /** The eye that came first has left no room for the other one: both ask for half. */
  share() {
    if (this.rateHz <= LEAST_RATE_HZ) return;
    this.rateHz = Math.max(LEAST_RATE_HZ, this.rateHz / 2);
    for (const eye of this.eyes.values()) this.connect(eye);
  }

  /**
   * @param {any} view of WebXR
   * @param {any} layer
   * @param {number} now milliseconds
   */
  drawEye(view, layer, now) {
    const { renderer } = this.viewer;
    const viewport = layer.getViewport(view);
    if (!renderer || renderer.lost || !viewport || viewport.width === 0) return;
    const eye = this.eyeOf(view.eye, viewport);
    const { position: p, orientation: q } = view.transform;
    const shown = rounded({
      position: add(this.gaze.position, rotate(this.gaze.level, [p.x, p.y, p.z])),
      orientation: normalized(multiply(this.gaze.level, [q.x, q.y, q.z, q.w])),
      near: NEAR,
      ...tangentsOf(view.projectionMatrix),
    });
    eye.look(withBorder(shown, eye.size), now);
    const next = eye.order.next(now) ?? eye.drawn ?? eye.plain;
    if (!next) return;
    if (eye.masks) {
      renderer.setLights(eye.masks.lights, eye.masks.lightsVersion);
      renderer.takeMasks(eye.masks, view.eye);
    }
    const wish = {
      camera: eye.shownCamera(next),
      width: eye.size.width,
      height: eye.size.height,
      sceneTimeUs: eye.masks?.sceneTimeUs ?? 0,
      lightsOn: this.viewer.picture.lightsOn,
      filter: this.viewer.picture.filter,
      accumulate: this.viewer.picture.accumulate,
      shadows: /** @type {'exact' | 'none'} */ (eye.masks ? 'exact' : 'none'),
      exposure: this.viewer.exposure ?? 1,
      eye: view.eye,
    };
    const { x, y, width, height } = viewport;
    renderer.drawInto(wish, { framebuffer: layer.framebuffer, x, y, width, height });
    eye.drawn = next;
  }
}
