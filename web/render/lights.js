// The lights as shaders read them: gpu::traced_light and light_colour. Five texels for each: position and reach;
// direction and the cosine of the outer cone; colour times intensity; scale and offset of the cone, kind, first layer
// of its shadow maps; first plane of the masks and sample points (wire/planes.js), layer of accumulated shares.
import { texture2d } from './gl.js';

const f = Math.fround;
export const MOST_LIGHTS = 256;
const TEXELS = 5; // of each
export const POINT = 0,
  SPOT = 1,
  DIRECTIONAL = 2;

/**
 * @typedef {{kind: number, position: number[], direction: number[], color: number[], intensity: number, range: number,
 *   innerConeCos: number, outerConeCos: number}} Light
 */

/** For a directional light the length of its segments, which exceeds the scene. */
export function reachOf(/** @type {Light} */ light, /** @type {{min: number[], max: number[]}} */ bounds) {
  if (light.kind !== DIRECTIONAL) return f(light.range);
  const size = bounds.max.map((high, i) => f(f(high) - f(bounds.min[i])));
  return f(2 * f(Math.sqrt(f(f(f(size[0] * size[0]) + f(size[1] * size[1])) + f(size[2] * size[2])))));
}

export class Lights {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {{min: number[], max: number[]}} bounds
   */
  constructor(gl, bounds) {
    this.gl = gl;
    this.bounds = bounds;
    this.texture = texture2d(gl, gl.RGBA32F, TEXELS, MOST_LIGHTS);
  }

  /**
   * @param {Light[]} lights at their places
   * @param {Uint8Array | null} on null: all
   * @param {number[]} mapLayers first layer of each light's shadow maps; -1: none
   * @param {import('../wire/planes.js').Planes} planes of the masks
   * @param {number[]} shareLayers of each light's accumulated shares; -1: none
   */
  put(lights, on, mapLayers, planes, shareLayers = []) {
    const rows = new Float32Array(4 * TEXELS * Math.max(1, lights.length));
    lights.forEach((light, i) => {
      const shines = on === null || on[i] !== 0;
      const spot = light.kind === SPOT;
      const scale = spot ? f(1 / Math.max(f(0.001), f(f(light.innerConeCos) - f(light.outerConeCos)))) : 0;
      rows.set(
        [
          ...light.position,
          reachOf(light, this.bounds),
          ...light.direction,
          light.outerConeCos,
          ...light.color.map((c) => (shines ? f(f(c) * f(light.intensity)) : 0)),
          0,
          scale,
          spot ? f(-f(light.outerConeCos) * scale) : 1,
          light.kind,
          mapLayers[i] ?? -1,
          planes.first[i],
          planes.samples[i],
          shareLayers[i] ?? -1,
        ],
        4 * TEXELS * i,
      );
    });
    const { gl } = this;
    gl.bindTexture(gl.TEXTURE_2D, this.texture.texture);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, TEXELS, Math.max(1, lights.length), gl.RGBA, gl.FLOAT, rows);
  }
}
