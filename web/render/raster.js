// The visibility buffer: which triangle each pixel of a view shows (gpu/passes/gbuffer.cpp).
import { Chunks } from './chunks.js';
import { framebuffer, texture2d } from './gl.js';

const FINEST = 64; // grid points per pixel that are taken for granted where no grid was found

/** Where ids are drawn: a picture of its size, with depth. */
export class IdTarget {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {number} width
   * @param {number} height
   */
  constructor(gl, width, height) {
    this.gl = gl;
    this.width = width;
    this.height = height;
    this.ids = texture2d(gl, gl.R32UI, width, height);
    this.depth = texture2d(gl, gl.DEPTH_COMPONENT32F, width, height);
    this.framebuffer = framebuffer(gl, this.ids, this.depth);
    /** What was drawn last, so that the same is not drawn again. */
    this.shows = '';
  }

  dispose() {
    this.gl.deleteFramebuffer(this.framebuffer);
    this.gl.deleteTexture(this.ids.texture);
    this.gl.deleteTexture(this.depth.texture);
  }
}

export class Raster {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {import('../pack/pack.js').ScenePack} pack
   * @param {import('./programs.js').Programs} programs
   */
  constructor(gl, pack, programs) {
    this.gl = gl;
    this.programs = programs;
    this.widening = 1 / (programs.grid.subpixels || FINEST);
    this.groups = pack.info.groups; // in the order of drawing
    this.chunks = new Chunks(pack);
    // Depth from 1 at the near plane to 0 at infinity keeps its precision far away. Without the extension depth is as
    // OpenGL's, from -1 to 1.
    this.clipControl = gl.getExtension('EXT_clip_control');
    this.array = gl.createVertexArray();
  }

  get reversedDepth() {
    return Boolean(this.clipControl);
  }

  /**
   * Draws the ids of a view into a target of its size.
   * @param {IdTarget} target
   * @param {import('./view.js').View} view
   * @param {Record<string, any>} scene uniforms of geometry and materials
   * @param {boolean} traced exactly as the server has them
   */
  drawIds(target, view, scene, traced) {
    const { gl, clipControl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.framebuffer);
    gl.viewport(0, 0, target.width, target.height);
    gl.depthMask(true);
    gl.clearBufferuiv(gl.COLOR, 0, [0, 0, 0, 0]);
    const programs = this.programs.raster(traced);
    const reversed = programs.tests || clipControl !== null; // tested fragments say their depth themselves
    gl.clearBufferfv(gl.DEPTH, 0, [reversed ? 0 : 1]);
    gl.depthFunc(reversed ? gl.GREATER : gl.LESS);
    if (clipControl) clipControl.clipControlEXT(clipControl.LOWER_LEFT_EXT, clipControl.ZERO_TO_ONE_EXT);
    const { width, height } = target;
    this.drawGroups(programs, { ...scene, ...view, picture_size: [width, height], widening: this.widening }, true);
    if (clipControl) clipControl.clipControlEXT(clipControl.LOWER_LEFT_EXT, clipControl.NEGATIVE_ONE_TO_ONE_EXT);
  }

  /** Draws depths alone, of both sides of all triangles, into the framebuffer that is bound. */
  drawDepths(
    /** @type {number[]} */ camera,
    /** @type {Float32Array} */ toClip,
    /** @type {Record<string, any>} */ scene,
  ) {
    this.gl.depthFunc(this.gl.LESS);
    this.drawGroups(this.programs.depths(), { ...scene, camera, camera_to_clip: toClip }, false);
  }

  /** @private */
  drawGroups(
    /** @type {ReturnType<import('./programs.js').Programs['raster']>} */ programs,
    /** @type {Record<string, any>} */ uniforms,
    /** @type {boolean} */ culls,
  ) {
    const { gl } = this;
    gl.bindVertexArray(this.array);
    gl.enable(gl.DEPTH_TEST);
    gl.disable(gl.BLEND);
    gl.cullFace(gl.BACK);
    gl.frontFace(gl.CW); // as y points down
    for (const group of this.groups) {
      const oneSided = culls && !group.double_sided;
      if (oneSided && !programs.tests) gl.enable(gl.CULL_FACE);
      else gl.disable(gl.CULL_FACE);
      const program = group.masked ? programs.masked : programs.opaque;
      program.use({ ...uniforms, one_sided: oneSided });
      for (const run of this.chunks.inView(group, uniforms.camera, uniforms.camera_to_clip)) {
        program.set('first_triangle', run.first);
        gl.drawArrays(gl.TRIANGLES, 0, 3 * run.count);
      }
    }
    gl.disable(gl.CULL_FACE);
  }

  dispose() {
    this.gl.deleteVertexArray(this.array);
  }
}
