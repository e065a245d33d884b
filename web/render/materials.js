// Materials and their textures on the device: gpu/scene/texels.cpp and resident_scene.cpp. Every level of every texture is
// a rectangle of one texture with layers, so that a full-screen pass can read them all.
import { Atlas } from './atlas.js';
import { List } from './lists.js';
import { TexelMaker } from './texels.js';

/** @type {Record<string, number>} */
const WRAPS = { repeat: 0, mirrored_repeat: 1, clamp_to_edge: 2 };
const DECODED_AT_ONCE = 3;

export class Materials {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {import('../pack/pack.js').ScenePack} pack
   */
  static async create(gl, pack) {
    const made = new Materials(gl, pack);
    await made.decode(gl, pack);
    return made;
  }

  /** @private */
  constructor(/** @type {WebGL2RenderingContext} */ gl, /** @type {import('../pack/pack.js').ScenePack} */ pack) {
    const { materials, textures } = pack.info;
    /** @type {number[]} textures that a material shows */
    this.used = [
      ...new Set(materials.map((/** @type {any} */ m) => m.texture).filter((/** @type {number} */ t) => t >= 0)),
    ];
    this.atlas = new Atlas(
      gl,
      this.used.map((t) => textures[t]),
    );
    /** @type {Map<number, number>} number in the atlas of each texture that is used */
    const numbers = new Map(this.used.map((texture, i) => [texture, i]));
    const firstLevel = 4 * materials.length;
    const rows = materials.flatMap((/** @type {import('../pack/pack.js').Material} */ m) => {
      const base = [...m.base_color, ...m.emissive, m.alpha_cutoff];
      if (m.texture < 0) return [...base, 0, 0, 0, 0, 0, 0, 0, 0];
      const texture = textures[m.texture];
      const levels = this.atlas.levels[/** @type {number} */ (numbers.get(m.texture))];
      return [
        ...base,
        texture.width,
        texture.height,
        levels.length,
        firstLevel + levels[0].number,
        WRAPS[texture.wrap_u],
        WRAPS[texture.wrap_v],
        0,
        0,
      ];
    });
    for (const level of this.atlas.levels.flat()) rows.push(level.x, level.y, level.layer, 0);
    this.records = new List(gl, 'float', rows.length / 4);
    this.records.put(0, Float32Array.from(rows));
  }

  get uniforms() {
    return { records: this.records, texels: this.atlas.texture };
  }

  /** @private */
  async decode(/** @type {WebGL2RenderingContext} */ gl, /** @type {import('../pack/pack.js').ScenePack} */ pack) {
    const maker = new TexelMaker(gl, this.atlas);
    let next = 0;
    const work = async () => {
      while (next < this.used.length && !gl.isContextLost()) {
        const number = next++;
        const texture = pack.info.textures[this.used[number]];
        const image = await pack.image(texture).catch(() => null);
        if (image) maker.make(image, texture, this.atlas.levels[number]);
        else this.leaveOut(pack, this.used[number]);
        image?.close();
      }
    };
    await Promise.all(Array.from({ length: DECODED_AT_ONCE }, work));
    maker.dispose();
  }

  /** A texture that cannot be decoded counts as none. @private */
  leaveOut(/** @type {import('../pack/pack.js').ScenePack} */ pack, /** @type {number} */ texture) {
    pack.info.materials.forEach((/** @type {any} */ material, /** @type {number} */ i) => {
      if (material.texture === texture) this.records.put(4 * i + 2, new Float32Array(4));
    });
  }

  dispose(/** @type {WebGL2RenderingContext} */ gl) {
    gl.deleteTexture(this.records.texture);
    gl.deleteTexture(this.atlas.texture.texture);
  }
}
