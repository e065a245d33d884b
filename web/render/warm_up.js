// Has the driver compile what the first pictures need while their scene is still on its way. Many compile only when
// something is drawn, and again for textures of another form: so one triangle is drawn with textures of those forms.
import { Atlas } from './atlas.js';
import { fill, framebuffer, texture2d } from './gl.js';
import { Lights } from './lights.js';
import { List } from './lists.js';
import { MaskTexture } from './masks.js';
import { IdTarget, Raster } from './raster.js';
import { LOOKUPS } from './shaders/shade.js';
import { TexelMaker } from './texels.js';
import { viewOf } from './view.js';

const SIDE = 6; // no power of two, as pictures hardly ever are
const BOUNDS = { min: [0, 0, 0], max: [1, 1, 1] };
const CAMERA = { position: [0, 0, 0], orientation: [0, 0, 0, 1], tanLeft: 1, tanRight: 1, tanUp: 1, tanDown: 1, near: 1 };

/** A scene of one triangle without size, drawn as opaque and as masked. */
const PACK = /** @type {any} */ ({
  info: {
    resting: { triangles: 0 },
    groups: [false, true].map((masked) => ({ first_triangle: 0, triangles: 1, masked, double_sided: true })),
  },
});

/** An atlas with the levels of one texture. */
function texelsOf(/** @type {WebGL2RenderingContext} */ gl) {
  const size = { width: SIDE, height: SIDE };
  const atlas = new Atlas(gl, [size]);
  const maker = new TexelMaker(gl, atlas);
  maker.make(new ImageData(SIDE, SIDE), size, atlas.levels[0]);
  maker.dispose();
  return atlas.texture;
}

/** @param {WebGL2RenderingContext} gl @param {import('./programs.js').Programs} programs */
export async function warmUp(gl, programs) {
  await programs.ready(); // what is asked of the driver once it draws waits for all that it compiles then
  if (!gl.isContextLost()) draw(gl, programs);
}

/** @param {WebGL2RenderingContext} gl @param {import('./programs.js').Programs} programs */
function draw(gl, programs) {
  const list = (/** @type {'float' | 'uint'} */ kind) => new List(gl, kind, SIDE << 12);
  const lists = {
    vertices: list('float'),
    normals: list('float'),
    triangles: list('uint'),
    records: new List(gl, 'float', 1),
  };
  const texels = texelsOf(gl);
  const masks = new MaskTexture(gl).texture;
  const lights = new Lights(gl, BOUNDS).texture;
  const picture = texture2d(gl, gl.RGBA8, SIDE, SIDE);
  const target = new IdTarget(gl, SIDE, SIDE);
  const raster = new Raster(gl, PACK, programs);
  const scene = { ...lists, texels };
  const view = viewOf(CAMERA, SIDE, SIDE, raster.reversedDepth);
  raster.drawIds(target, view, scene, true);
  const into = framebuffer(gl, picture, null);
  programs.shade(LOOKUPS.MASKS).use({ ...scene, ...view, ids: target.ids, masks, lights });
  fill(gl, SIDE, SIDE);
  gl.flush();
  gl.deleteFramebuffer(into);
  for (const made of [...Object.values(lists), texels, masks, lights, picture]) gl.deleteTexture(made.texture);
  target.dispose();
  raster.dispose();
}
