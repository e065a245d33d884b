// What is compiled for a context, whatever its scene: each program once, those of the first picture as early as a page can
// have them, as compilers take longer than a scene needs to come.
import { FULL_SCREEN, Program } from './gl.js';
import { findGrid } from './grid.js';
import { rowBits } from './lists.js';
import { AVERAGE } from './shaders/average.js';
import { LEVEL } from './shaders/level.js';
import { OUTLINE_FRAGMENT, OUTLINE_VERTEX } from './shaders/outline.js';
import { RASTER_FRAGMENT, RASTER_VERTEX } from './shaders/raster.js';
import { LOOKUPS, shadeFragment } from './shaders/shade.js';

/** @type {WeakMap<WebGL2RenderingContext, Programs>} */
const known = new WeakMap();

export class Programs {
  /** Those of a context. They are made again where it was lost. */
  static of(/** @type {WebGL2RenderingContext} */ gl) {
    let programs = known.get(gl);
    if (!programs) {
      known.set(gl, (programs = new Programs(gl)));
      gl.canvas.addEventListener('webglcontextlost', () => known.delete(gl), { once: true });
    }
    return programs;
  }

  /** @private */
  constructor(/** @type {WebGL2RenderingContext} */ gl) {
    this.gl = gl;
    /** @type {Map<string, Program>} */
    this.made = new Map();
    this.grid = findGrid(gl);
    this.shade(LOOKUPS.MASKS);
    for (const traced of [true, false]) this.raster(traced);
    this.shade(LOOKUPS.SEEN);
    this.level();
  }

  /** Resolves when pictures can be drawn without holding the page up. */
  async ready() {
    await Promise.all([...this.made.values()].map((program) => program.ready()));
  }

  /**
   * The program of that name, made when it is first asked for.
   * @param {string} name
   * @param {string} vertex
   * @param {() => string} fragment
   * @param {Record<string, number>} [defines]
   */
  get(name, vertex, fragment, defines = {}) {
    let program = this.made.get(name);
    if (!program) {
      program = new Program(this.gl, vertex, fragment(), { ROW_BITS: rowBits(this.gl), ...defines });
      this.made.set(name, program);
    }
    return program;
  }

  /** For every pixel of a target. */
  fullScreen(
    /** @type {string} */ name,
    /** @type {() => string} */ fragment,
    /** @type {Record<string, number>} */ defines = {},
  ) {
    return this.get(name, FULL_SCREEN, fragment, defines);
  }

  /** Which triangle a pixel shows; `traced`: exactly as the server has it, on whichever grid this device has. */
  raster(/** @type {boolean} */ traced) {
    const tests = traced && !this.grid.exact;
    const [name, vertex, fragment] = tests
      ? ['outline', OUTLINE_VERTEX, OUTLINE_FRAGMENT]
      : ['raster', RASTER_VERTEX, RASTER_FRAGMENT];
    return {
      tests,
      opaque: this.get(name, vertex, () => fragment),
      masked: this.get(`${name} masked`, vertex, () => fragment, { MASKED: 1 }),
    };
  }

  /** Depths alone. */
  depths() {
    const fragment = () => RASTER_FRAGMENT;
    return {
      tests: false,
      opaque: this.get('depth', RASTER_VERTEX, fragment, { DEPTH_ALONE: 1 }),
      masked: this.get('depth masked', RASTER_VERTEX, fragment, { DEPTH_ALONE: 1, MASKED: 1 }),
    };
  }

  /**
   * The shading pass for a value of LOOKUPS.
   * @param {number} lookup
   * @param {{window?: boolean, shares?: boolean}} more window: where pixels around have a say; shares: with those that
   *   were accumulated in the place of what the masks say
   */
  shade(lookup, { window = false, shares = false } = {}) {
    const name = `shade ${lookup}${window ? ' window' : ''}${shares ? ' shares' : ''}`;
    const fragment = () => shadeFragment(lookup, window, shares);
    return this.fullScreen(name, fragment, { LOOKUP: lookup, SHARES: Number(shares) });
  }

  /** Of the levels of textures. */
  level() {
    return this.fullScreen('level', () => LEVEL);
  }

  average() {
    return this.fullScreen('average', () => AVERAGE);
  }
}
