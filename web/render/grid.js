// Finds the grid to which the device rounds the corners of triangles, by drawing triangles whose left edge is a little
// right of a pixel's centre: those that show were rounded to it. What WebGL says of its grid (SUBPIXEL_BITS) is not what
// devices do. The server's grid is 1/256 of a pixel; on another one, edges would fall on other pixels now and then, which
// shaders/outline.js puts right.
import { framebuffer, Program, texture2d } from './gl.js';

const STEPS = 2048; // of a pixel
const ROWS = 160; // the edge of row i is i steps beside the centre

const VERTEX = `
void main() {
  int row = gl_VertexID / 3, corner = gl_VertexID % 3;
  float x = corner == 2 ? 4.0 : 1.5 + float(row) / ${STEPS}.0;
  float y = float(row) + (corner == 0 ? 0.125 : corner == 1 ? 0.875 : 0.5);
  gl_Position = vec4(x / 4.0 - 1.0, y / ${ROWS / 2}.0 - 1.0, 0.0, 1.0);
}
`;
const FRAGMENT = 'out uint shown; void main() { shown = 1u; }';

/** @typedef {{exact: boolean, subpixels: number}} Grid `subpixels`: grid points per pixel, 0 where no grid was found */

/**
 * @param {WebGL2RenderingContext} gl
 * @returns {Grid}
 */
export function findGrid(gl) {
  const target = texture2d(gl, gl.R32UI, 8, ROWS);
  const buffer = framebuffer(gl, target, null);
  const program = new Program(gl, VERTEX, FRAGMENT);
  gl.clearBufferuiv(gl.COLOR, 0, [0, 0, 0, 0]);
  program.use({});
  gl.viewport(0, 0, 8, ROWS);
  gl.disable(gl.DEPTH_TEST);
  gl.disable(gl.CULL_FACE);
  gl.drawArrays(gl.TRIANGLES, 0, 3 * ROWS);
  const shown = new Uint32Array(8 * ROWS);
  gl.readPixels(0, 0, 8, ROWS, gl.RED_INTEGER, gl.UNSIGNED_INT, shown);
  gl.deleteFramebuffer(buffer);
  gl.deleteTexture(target.texture);
  program.dispose();
  let rounded = 0; // the farthest edge that was rounded to the centre, in steps
  while (rounded + 1 < ROWS && shown[8 * (rounded + 1) + 1] !== 0) ++rounded;
  // An edge exactly between two grid points may go either way.
  const subpixels = rounded === 0 ? 0 : 2 ** Math.round(Math.log2(STEPS / (2 * (rounded + 0.5))));
  return { exact: subpixels === 256 && shown[1] !== 0, subpixels };
}
