// Plain shadow maps, for comparison with masks: a map of 1024 x 1024 depths for each spot and directional light, six for
// each point light. A light's maps are drawn again when it has moved, or when anything in the scene has.
import { RenderError, texture2d, textureArray } from './gl.js';
import { DIRECTIONAL, POINT } from './lights.js';

const SIDE = 1024;
const MOST_LAYERS = 64; // 256 MiB
const NEAR = 0.02; // metres
const TEXELS = 6; // of a record: the columns of the matrix, the width of a texel, the matrix' origin
const WIDEST = 8; // tangent of half of the widest cone that one map covers

/** @typedef {{toClip: Float32Array, origin: number[], texel: number[]}} Frustum */

export class ShadowMaps {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {{min: number[], max: number[]}} bounds
   */
  constructor(gl, bounds) {
    this.gl = gl;
    this.bounds = bounds;
    this.texture = /** @type {(import('./gl.js').Texture & {layers: number}) | null} */ (null);
    this.records = texture2d(gl, gl.RGBA32F, TEXELS, MOST_LAYERS);
    this.framebuffer = /** @type {WebGLFramebuffer} */ (gl.createFramebuffer());
    /** @type {string[]} what each light's maps show */
    this.drawn = [];
    /** @type {number[]} */
    this.layers = [];
  }

  get uniforms() {
    return { shadow_maps: this.texture, map_records: this.records };
  }

  /**
   * Brings the maps up to date. Returns the first layer of each light, -1 for lights that have no room.
   * @param {import('./lights.js').Light[]} lights at their places
   * @param {string} scene changes whenever anything but lights has moved
   * @param {(camera: number[], toClip: Float32Array) => void} drawDepths
   */
  update(lights, scene, drawDepths) {
    this.makeRoom(lights);
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
    lights.forEach((light, i) => {
      const shows = scene + JSON.stringify(light);
      if (this.layers[i] < 0 || this.drawn[i] === shows) return;
      this.drawn[i] = shows;
      frustaOf(light, this.bounds).forEach((frustum, k) => this.draw(this.layers[i] + k, frustum, drawDepths));
    });
    return this.layers;
  }

  /** @private */
  makeRoom(/** @type {import('./lights.js').Light[]} */ lights) {
    let layers = 0;
    const places = lights.map((light) => {
      const count = light.kind === POINT ? 6 : 1;
      if (layers + count > MOST_LAYERS) return -1;
      layers += count;
      return layers - count;
    });
    if (this.texture && this.layers.join() === places.join()) return;
    const { gl } = this;
    if (this.texture) gl.deleteTexture(this.texture.texture);
    this.texture = textureArray(gl, gl.DEPTH_COMPONENT24, SIDE, SIDE, Math.max(1, layers));
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_COMPARE_FUNC, gl.LEQUAL);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    this.layers = places;
    this.drawn = [];
  }

  /** @private */
  draw(
    /** @type {number} */ layer,
    /** @type {Frustum} */ frustum,
    /** @type {(camera: number[], toClip: Float32Array) => void} */ drawDepths,
  ) {
    const { gl } = this;
    if (!this.texture) throw new RenderError('Shadow maps have no room.');
    gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, this.texture.texture, 0, layer);
    gl.viewport(0, 0, SIDE, SIDE);
    gl.depthMask(true);
    gl.clearBufferfv(gl.DEPTH, 0, [1]);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1.5, 4);
    drawDepths(frustum.origin, frustum.toClip);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    gl.bindTexture(gl.TEXTURE_2D, this.records.texture);
    gl.texSubImage2D(
      gl.TEXTURE_2D,
      0,
      0,
      layer,
      TEXELS,
      1,
      gl.RGBA,
      gl.FLOAT,
      Float32Array.from([...frustum.toClip, ...frustum.texel, 0, 0, ...frustum.origin, 0]),
    );
  }

  dispose() {
    const { gl } = this;
    if (this.texture) gl.deleteTexture(this.texture.texture);
    gl.deleteTexture(this.records.texture);
    gl.deleteFramebuffer(this.framebuffer);
  }
}

/** @returns {Frustum[]} */
function frustaOf(/** @type {import('./lights.js').Light} */ light, /** @type {any} */ bounds) {
  const diagonal = Math.hypot(
    ...bounds.max.map((/** @type {number} */ high, /** @type {number} */ i) => high - bounds.min[i]),
  );
  if (light.kind === DIRECTIONAL) return [orthographic(light.direction, bounds)];
  const far = Math.max(light.range > 0 ? light.range : 2 * diagonal, 2 * NEAR);
  if (light.kind !== POINT) {
    const cosine = Math.max(light.outerConeCos, 1e-3);
    const tangent = Math.min(Math.sqrt(Math.max(1 / (cosine * cosine) - 1, 1e-6)), WIDEST);
    return [perspective(light.position, light.direction, 1.02 * tangent, far)];
  }
  return [0, 1, 2].flatMap((axis) =>
    [1, -1].map((sign) => {
      const ahead = [0, 0, 0];
      ahead[axis] = sign;
      return perspective(light.position, ahead, 1, far);
    }),
  );
}

/** Two unit vectors beside a unit vector. */
function beside(/** @type {number[]} */ ahead) {
  const other = Math.abs(ahead[1]) < 0.9 ? [0, 1, 0] : [1, 0, 0];
  const right = unit(cross(ahead, other));
  return [right, cross(right, ahead)];
}

function perspective(
  /** @type {number[]} */ origin,
  /** @type {number[]} */ ahead,
  /** @type {number} */ tangent,
  /** @type {number} */ far,
) {
  const [right, up] = beside(ahead);
  const depth = ahead.map((a) => (a * (far + NEAR)) / (far - NEAR));
  const rows = [
    [...right.map((r) => r / tangent), 0],
    [...up.map((u) => u / tangent), 0],
    [...depth, (-2 * far * NEAR) / (far - NEAR)],
    [...ahead, 0],
  ];
  return { toClip: columns(rows), origin: [...origin], texel: [0, (2 * tangent) / SIDE] };
}

/** The box around the scene along the light's axes. */
function orthographic(/** @type {number[]} */ ahead, /** @type {any} */ bounds) {
  const origin = bounds.min.map((/** @type {number} */ low, /** @type {number} */ i) => (low + bounds.max[i]) / 2);
  const half = bounds.max.map((/** @type {number} */ high, /** @type {number} */ i) => high - origin[i]);
  const axes = [...beside(ahead), ahead];
  const reach = axes.map((axis) => axis.reduce((sum, a, i) => sum + Math.abs(a) * half[i], 1e-3));
  const rows = axes.map((axis, i) => [...axis.map((a) => a / reach[i]), 0]);
  return {
    toClip: columns([...rows, [0, 0, 0, 1]]),
    origin,
    texel: [(2 * Math.max(reach[0], reach[1])) / SIDE, 0],
  };
}

function columns(/** @type {number[][]} */ rows) {
  return Float32Array.from({ length: 16 }, (_, i) => rows[i % 4][i >> 2]);
}

function cross(/** @type {number[]} */ a, /** @type {number[]} */ b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

function unit(/** @type {number[]} */ v) {
  const length = Math.hypot(...v);
  return v.map((value) => value / length);
}
