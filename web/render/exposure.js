// gpu::ReferenceView::suggest_exposure: an exposure that turns the view's geometric mean luminance, with every light
// visible everywhere, into a mid grey.
import { fill, framebuffer, texture2d } from './gl.js';
import { shadingUniforms } from './picture.js';
import { LOOKUPS, VIEWS } from './shaders/shade.js';

const MID_GREY = 0.18;
const WIDTH = 160,
  HEIGHT = 96;

/**
 * The lights and the scene stand at the scene time 0.
 * @param {import('./stage.js').Stage} stage
 * @param {any} surroundings
 * @param {import('./view.js').Camera} camera
 * @param {number} lightCount
 */
export function suggestExposure(stage, surroundings, camera, lightCount) {
  const { gl } = stage;
  const { ids, view } = stage.idsOf('exposure', camera, WIDTH, HEIGHT, true);
  const target = texture2d(gl, gl.RGBA8, WIDTH, HEIGHT);
  const buffer = framebuffer(gl, target, null);
  gl.bindVertexArray(stage.array);
  stage.programs.shade(LOOKUPS.MASKS).use({
    ...stage.sceneUniforms,
    ...view,
    ids,
    lights: stage.lights.texture,
    light_count: lightCount,
    first_pixel: [0, 0],
    flipped_height: 0,
    ...shadingUniforms(surroundings, {}),
    view: VIEWS.luminance,
    masked: false,
    masks: stage.masksOf().texture,
  });
  fill(gl, WIDTH, HEIGHT);
  const bytes = new Uint8Array(4 * WIDTH * HEIGHT);
  gl.readPixels(0, 0, WIDTH, HEIGHT, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  gl.deleteFramebuffer(buffer);
  gl.deleteTexture(target.texture);
  stage.dropTarget('exposure');
  return exposureOf(new Float32Array(bytes.buffer));
}

/** The geometric mean, so that a lamp in view hardly affects the exposure. */
export function exposureOf(/** @type {Float32Array} */ luminances) {
  let sum = 0,
    surfaces = 0;
  for (const luminance of luminances) {
    if (!(luminance > 0) || !Number.isFinite(luminance)) continue;
    sum += Math.log(luminance);
    ++surfaces;
  }
  return surfaces === 0 ? 1 : MID_GREY / Math.exp(sum / surfaces);
}
