// Runs in the page: the renderer's pictures beside those of the reference client (draw_inputs.cpp), as figures.
import { fetchPack, ScenePack } from '/pack/pack.js';
import { poseInstance } from '/pack/pose.js';
import { Renderer } from '/render/renderer.js';
import { viewOf } from '/render/view.js';
import { planesOf } from '/wire/planes.js';

const LEAST_STEP = 2; // of 255: differences up to it are not seen

async function bytes(url) {
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url}: ${response.status}`);
  return response.arrayBuffer();
}

/** Share of pixels within LEAST_STEP, PSNR, the worst difference. */
export function compare(mine, theirs) {
  let squares = 0;
  let near = 0;
  let worst = 0;
  const pixels = mine.length / 4;
  for (let pixel = 0; pixel < pixels; ++pixel) {
    let most = 0;
    for (let c = 0; c < 3; ++c) {
      const step = Math.abs(mine[4 * pixel + c] - theirs[4 * pixel + c]);
      squares += step * step;
      most = Math.max(most, step);
    }
    near += most <= LEAST_STEP ? 1 : 0;
    worst = Math.max(worst, most);
  }
  return { near: near / pixels, psnr: 10 * Math.log10((255 * 255) / (squares / (3 * pixels) || 1e-9)), worst };
}

/** Share of pixels that one of two pictures of a light shows and the other does not. */
function bitsOff(mine, theirs) {
  let off = 0;
  const shows = (picture, at) => picture[at] + picture[at + 1] + picture[at + 2] > 0;
  for (let at = 0; at < mine.length; at += 4) off += shows(mine, at) !== shows(theirs, at) ? 1 : 0;
  return off / (mine.length / 4);
}

function base64(data) {
  let text = '';
  for (let at = 0; at < data.length; at += 0x8000) text += String.fromCharCode(...data.subarray(at, at + 0x8000));
  return btoa(text);
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const minus = (a, b) => a.map((value, i) => value - b[i]);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

/** The point of a resting triangle's plane that a pixel shows, and the normal on the camera's side. */
function surfaces(pack, view) {
  return (id, at) => {
    const [x, y] = [at % view.width, Math.floor(at / view.width)];
    const ray = view.ray_corner.map((corner, i) => corner + (x + 0.5) * view.ray_dx[i] + (y + 0.5) * view.ray_dy[i]);
    const [a, b, c] = [0, 1, 2].map((k) => {
      const vertex = pack.triangles[3 * (id - 1) + k];
      return Array.from(pack.positions.subarray(3 * vertex, 3 * vertex + 3));
    });
    const n = cross(minus(b, a), minus(c, a));
    const across = dot(n, ray);
    const depth = across ? dot(n, minus(a, view.camera)) / across : 0;
    const length = Math.hypot(...n) * (across > 0 ? -1 : 1);
    return { depth, point: ray.map((r, i) => view.camera[i] + depth * r), normal: n.map((value) => value / length) };
  };
}

/** The same surface to within a pixel's width, as predict.comp has it. */
function same(a, b, view) {
  const reach = a.depth * Math.hypot(...view.ray_dx);
  const apart = minus(b.point, a.point);
  return (
    dot(a.normal, b.normal) > 0.5 && Math.abs(dot(apart, a.normal)) <= reach && Math.abs(dot(apart, b.normal)) <= reach
  );
}

export class Checks {
  static async open(inputs) {
    const checks = new Checks();
    checks.inputs = inputs;
    checks.plan = await (await fetch(`${inputs}/views.json`)).json();
    const progress = [];
    const onProgress = (done, total) => progress.push([done, total]);
    checks.pack = new ScenePack(await fetchPack(`${inputs}/scene.pack`, { onProgress }));
    checks.progress = progress.at(-1);
    checks.canvas = document.createElement('canvas');
    document.body.append(checks.canvas);
    checks.renderer = await Renderer.create(checks.canvas, checks.pack);
    checks.renderer.setLights(checks.plan.lights, 0);
    return checks;
  }

  get facts() {
    const { gl, grid, pack } = this.renderer;
    const info = gl.getExtension('WEBGL_debug_renderer_info');
    return {
      grid,
      triangles: pack.triangleCount,
      lights: this.plan.lights.length,
      device: gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER),
      clipControl: Boolean(gl.getExtension('EXT_clip_control')),
      error: gl.getError(),
    };
  }

  /** What to draw of view i, with its masks taken. */
  async wish(i, more = {}) {
    const { width, height, scene_time_us: sceneTimeUs, views } = this.plan;
    const { camera, exposure } = views[i];
    const words = new Uint32Array(await bytes(`${this.inputs}/${i}.words`));
    this.renderer.takeMasks({ camera, width, height, words, sceneTimeUs });
    return { camera, width, height, sceneTimeUs, exposure, shadows: 'exact', ...more };
  }

  async softMasks(i) {
    const words = new Uint32Array(await bytes(`${this.inputs}/${i}.soft.words`));
    return { words, planes: planesOf(this.plan.areas, this.plan.soft_samples) };
  }

  /** As wish(), with masks that count points of area lights. `kind`: soft or half. */
  async countedWish(i, kind, more = {}) {
    const { width, height, scene_time_us: sceneTimeUs, views, areas } = this.plan;
    const { camera, exposure } = views[i];
    const words = new Uint32Array(await bytes(`${this.inputs}/${i}.${kind}.words`));
    const planes = planesOf(areas, this.plan[`${kind}_samples`]);
    this.renderer.takeMasks({ camera, width, height, words, planes, sceneTimeUs });
    return { camera, width, height, sceneTimeUs, exposure, shadows: 'exact', ...more };
  }

  /** Masks of view 0, with the picture shifted by some pixels. */
  async shiftedMasks(shift) {
    const { width, height, scene_time_us: sceneTimeUs, shifted, areas, shifted_samples: samples } = this.plan;
    const words = new Uint32Array(await bytes(`${this.inputs}/0.shifted.${shift}.words`));
    return { camera: shifted[shift], width, height, words, planes: planesOf(areas, samples), sceneTimeUs };
  }

  /** The picture of a wish once the renderer has taken these masks, one after the other. */
  after(masks, wish) {
    this.renderer.stage.dropAccumulation();
    for (const each of masks.slice(0, -1)) {
      this.renderer.takeMasks(each);
      this.renderer.draw(wish);
    }
    this.renderer.takeMasks(masks.at(-1));
    this.renderer.wish = wish;
    return this.renderer.readPixels(); // which draws
  }

  /** Of pictures of view 0 with masks accumulated: how many numbers differ from those of the newest masks alone. */
  async accumulated() {
    const { width, height, views, lights, areas } = this.plan;
    const [{ camera, exposure, predicted }] = views;
    const plain = { camera, width, height, exposure, shadows: 'exact' };
    const wish = { ...plain, accumulate: true };
    const shifts = await Promise.all([3, 2, 1, 0].map((shift) => this.shiftedMasks(shift)));
    const newest = shifts.at(-1);
    const again = () => ({ ...newest, words: newest.words.slice() });
    const filled = (make) => ({ ...newest, words: newest.words.map(make) });
    const differ = (masks, more = {}) => {
      const alone = this.after([masks.at(-1)], { ...plain, ...more });
      const together = this.after(masks, { ...wish, ...more });
      return together.reduce((count, value, at) => count + (value === alone[at] ? 0 : 1), 0);
    };
    let seed = 1;
    const noise = () => (seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0);
    const noisy = [0, 1, 2].map(() => filled(noise));
    const same = [again(), again(), again(), again()];
    const halfPlanes = planesOf(areas, this.plan.half_samples);
    const half = new Uint32Array(await bytes(`${this.inputs}/0.half.words`));
    const halves = [0, 1, 2].map(() => ({ ...newest, words: half.slice(), planes: halfPlanes }));
    const off = {
      same: differ(same),
      samePredicted: differ(same.slice(1), { camera: predicted }),
      sameFiltered: differ(same.slice(2), { filter: true }),
      sameHalf: differ(halves),
      shifted: differ(shifts),
      otherLights: differ([...shifts.slice(0, 3), { ...newest, lightsVersion: 1 }]),
      otherSession: differ([...shifts.slice(0, 3), { ...newest, session: 1 }]),
      darkBefore: differ([filled(() => 0), filled(() => 0), filled(() => 0xffffffff)]),
      afterNoise: [1, 2, 3, 4].map((masks) => differ([...noisy, ...same.slice(0, masks)])),
    };
    // Beside the picture of four times as many points.
    const reference = { ...newest, ...(await this.softMasks(0)) };
    let [alone, together] = [0, 0];
    for (let light = 0; light < lights.length; ++light) {
      if (!areas[light]) continue;
      const more = { view: 'material', onlyLight: light };
      const many = this.after([reference], { ...plain, ...more });
      const errorOf = (picture) => picture.reduce((sum, value, at) => sum + (value - many[at]) ** 2, 0);
      alone += errorOf(this.after([newest], { ...plain, ...more }));
      together += errorOf(this.after(shifts, { ...wish, ...more }));
    }
    return { ...off, error: together / alone, glError: this.renderer.gl.getError() };
  }

  /** Draws and compares with the picture of that name; with `keep` the pixels come along. */
  async picture(wish, name, keep = false) {
    const began = performance.now();
    const { predicted } = this.renderer.draw(wish);
    const mine = this.renderer.readPixels();
    const ms = performance.now() - began;
    const theirs = name ? new Uint8Array(await bytes(`${this.inputs}/${name}.rgba`)) : mine;
    return {
      ...compare(mine, theirs),
      predicted,
      ms,
      error: this.renderer.gl.getError(),
      ...(keep ? { rgba: base64(mine) } : {}),
    };
  }

  /** How many numbers of the vertices and lights that move are not those of the server. */
  async posed() {
    const { pack } = this;
    const { motion } = this.renderer.stage.geometry;
    const time = this.plan.scene_time_us;
    const first = pack.info.resting.vertices;
    const mine = { position: [], normal: [] };
    const into = {
      position: (v, ...xyz) => (mine.position[v - first] = xyz),
      normal: (v, ...xyz) => (mine.normal[v - first] = xyz),
      triangle: () => {},
    };
    const toWorld = motion.transforms(time);
    for (const instance of motion.instances) poseInstance(pack, instance, toWorld[instance.node], into);
    const off = async (name, numbers) => {
      const theirs = new Float32Array(await bytes(`${this.inputs}/posed.${name}`));
      const flat = Float32Array.from(numbers.flat());
      if (flat.length !== theirs.length) return -1;
      return theirs.reduce((count, value, i) => count + (value === flat[i] ? 0 : 1), 0);
    };
    const lights = motion.lightsAt(this.plan.lights, time);
    const lightsOff = lights.filter(
      (light, i) => JSON.stringify(light) !== JSON.stringify({ ...light, ...this.plan.posed_lights[i] }),
    );
    return {
      vertices: mine.position.length,
      positions: await off('positions', mine.position),
      normals: await off('normals', mine.normal),
      lightsMoved: lights.filter((light, i) => light !== this.plan.lights[i]).length,
      lights: lightsOff.length,
    };
  }

  /** Share of the bits of view i that were wrong as a prediction of the later camera, beside the native figure. */
  async outcome(i) {
    const { width, height, scene_time_us: sceneTimeUs, views } = this.plan;
    const masks = async (name, camera) => {
      const words = new Uint32Array(await bytes(`${this.inputs}/${name}.words`));
      return { camera, width, height, words, sceneTimeUs };
    };
    const seen = await masks(i, views[i].camera);
    const later = await masks(`${i}.later`, views[i].predicted);
    const share = await this.renderer.outcome(seen, later, views[i].predicted, { width, height });
    return { share, native: views[i].outcome };
  }

  /** Shares of pixels whose triangle, and whose surface, is not the server's. */
  async ids(i) {
    const wish = await this.wish(i);
    this.renderer.draw(wish);
    const { gl, stage } = this.renderer;
    const { width, height } = this.plan;
    gl.bindFramebuffer(gl.FRAMEBUFFER, stage.targets.get('seen ').framebuffer);
    const mine = new Uint32Array(width * height);
    gl.readPixels(0, 0, width, height, gl.RED_INTEGER, gl.UNSIGNED_INT, mine);
    const theirs = new Uint32Array(await bytes(`${this.inputs}/${i}.ids`));
    const view = viewOf(wish.camera, width, height, true);
    const surface = surfaces(this.pack, view);
    let differ = 0;
    let other = 0;
    mine.forEach((id, at) => {
      if (id === theirs[at]) return;
      ++differ;
      if (!id || !theirs[at] || !same(surface(id, at), surface(theirs[at], at), view)) ++other;
    });
    return { differ: differ / mine.length, other: other / mine.length };
  }

  /** The picture of view i without a border that its masks have: how many numbers differ from that part of the whole. */
  async cropped(i) {
    const wish = await this.wish(i);
    const [left, top, width, height] = [40, 24, wish.width - 96, wish.height - 64];
    const { tanLeft, tanRight, tanUp, tanDown } = wish.camera;
    const across = (tanLeft + tanRight) / wish.width;
    const upright = (tanUp + tanDown) / wish.height;
    const camera = {
      ...wish.camera,
      tanLeft: Math.fround(tanLeft - left * across),
      tanRight: Math.fround((left + width) * across - tanLeft),
      tanUp: Math.fround(tanUp - top * upright),
      tanDown: Math.fround((top + height) * upright - tanUp),
    };
    this.renderer.draw(wish);
    const whole = this.renderer.readPixels();
    const { predicted } = this.renderer.draw({ ...wish, camera, width, height });
    const part = this.renderer.readPixels();
    let off = 0;
    part.forEach((value, at) => {
      const [x, y] = [Math.floor(at / 4) % width, Math.floor(at / 4 / width)];
      off += value === whole[4 * ((y + top) * wish.width + x + left) + (at % 4)] ? 0 : 1;
    });
    return { predicted, off };
  }

  /** How many numbers of each half of a split picture differ from the whole one with exact shadows. */
  async split(i) {
    const wish = await this.wish(i);
    this.renderer.draw(wish);
    const whole = this.renderer.readPixels();
    this.renderer.draw({ ...wish, split: { at: 0.5, left: 'maps', right: 'exact' } });
    const halves = this.renderer.readPixels();
    const off = { left: 0, right: 0 };
    halves.forEach((value, at) => {
      if (value !== whole[at]) ++off[Math.floor(at / 4) % wish.width < wish.width / 2 ? 'left' : 'right'];
    });
    return off;
  }

  /** The brightest number of view i with all lights switched off. */
  async dark(i) {
    const wish = await this.wish(i);
    this.renderer.draw({ ...wish, lightsOn: new Uint8Array(this.plan.lights.length) });
    const off = this.renderer.readPixels();
    this.renderer.draw(wish);
    const on = this.renderer.readPixels();
    const mean = (pixels) => pixels.reduce((sum, value, at) => sum + (at % 4 < 3 ? value : 0), 0) / pixels.length;
    return { off: mean(off), on: mean(on) };
  }

  /** Takes the context away and gives it back: the picture's figures afterwards, and what was said meanwhile. */
  async lose(i) {
    const { renderer } = this;
    const extension = renderer.gl.getExtension('WEBGL_lose_context');
    const happens = (name) => new Promise((resolve) => this.canvas.addEventListener(name, resolve, { once: true }));
    const wish = await this.wish(i);
    const lost = happens('webglcontextlost');
    extension.loseContext();
    await lost;
    // The browser sees only after the event that the page wants the context back.
    await new Promise((go) => setTimeout(go));
    const meanwhile = { lost: renderer.lost, ...renderer.draw(wish) };
    const restored = new Promise((resolve) => (renderer.onRestored = resolve));
    extension.restoreContext();
    await restored;
    return { meanwhile, ...(await this.picture(wish, `${i}`)) };
  }

  async lights(i) {
    const wish = await this.wish(i);
    const off = [];
    for (let light = 0; light < this.plan.lights.length; ++light) {
      this.renderer.draw({ ...wish, view: 'material', onlyLight: light });
      const theirs = new Uint8Array(await bytes(`${this.inputs}/${i}.light.${light}.rgba`));
      off.push(bitsOff(this.renderer.readPixels(), theirs));
    }
    return off;
  }
}
