// For each pixel of a view, the pixel of a view seen before that shows the same surface: gpu::Reprojection::sources.
import { fill } from './gl.js';
import { EXACT } from './shaders/exact.js';
import { SCENE, VIEW } from './shaders/frame.js';
import { PREDICT } from './shaders/predict.js';
import { seenUniforms } from './view.js';

const FIND =
  EXACT +
  SCENE +
  VIEW +
  PREDICT +
  `
uniform usampler2D ids;
uniform uint resting;  // the highest id of what may be found
out uint source;  // 1 + the seen view's pixel, counted row by row; 0: none

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uint id = texelFetch(ids, pixel, 0).x;
  ivec2 found = id == 0u || id > resting ? kNowhere : source_of(surface_of(triangle_of(id - 1u), pixel));
  if (found.x >= 0 && texelFetch(seen_ids, found, 0).x > resting) found = kNowhere;
  source = found.x < 0 ? 0u : 1u + uint(found.y * seen_size.x + found.x);
}
`;

/** @typedef {{ids: import('./gl.js').Texture, view: import('./view.js').View}} Seen what idsOf() of a stage gives */

/**
 * @param {import('./stage.js').Stage} stage
 * @param {Seen} shown
 * @param {Seen} seen
 * @param {object} how
 * @param {WebGLFramebuffer} how.into of the shown view's size
 * @param {boolean} [how.sameEye] whether the two differ in the places of their samples alone
 * @param {number} [how.resting] of the first so many triangles alone
 */
export function findSources(stage, shown, seen, { into, sameEye = false, resting = 0xffffffff }) {
  const { gl } = stage;
  const { ids, view } = shown;
  gl.bindFramebuffer(gl.FRAMEBUFFER, into);
  gl.bindVertexArray(stage.array);
  const { sceneUniforms } = stage;
  stage.programs
    .fullScreen('sources', () => FIND)
    .use({ ...sceneUniforms, ...view, ids, ...seenUniforms(seen.view), seen_ids: seen.ids, same_eye: sameEye, resting });
  fill(gl, view.width, view.height);
}
