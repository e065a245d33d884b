// The scene's triangles on the device: gpu::ResidentScene. Moving vertices have their places behind the resting ones and
// are written again when the scene time changes.
import { Motion } from '../pack/motion.js';
import { poseInstance } from '../pack/pose.js';
import { List } from './lists.js';

export class Geometry {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {import('../pack/pack.js').ScenePack} pack
   */
  constructor(gl, pack) {
    this.pack = pack;
    this.motion = new Motion(pack);
    this.vertices = new List(gl, 'float', pack.vertexCount);
    this.normals = new List(gl, 'float', pack.vertexCount);
    this.triangles = new List(gl, 'uint', pack.triangleCount);
    const { positions, normals, uvs, triangles, triangleMaterials } = pack;
    this.vertices.fill(0, pack.vertexCount, (v, into, at) => {
      ((into[at] = positions[3 * v]), (into[at + 1] = positions[3 * v + 1]), (into[at + 2] = positions[3 * v + 2]));
      into[at + 3] = uvs[2 * v];
    });
    this.normals.fill(0, pack.vertexCount, (v, into, at) => {
      ((into[at] = normals[3 * v]), (into[at + 1] = normals[3 * v + 1]), (into[at + 2] = normals[3 * v + 2]));
      into[at + 3] = uvs[2 * v + 1];
    });
    this.triangles.fill(0, pack.triangleCount, (t, into, at) => {
      ((into[at] = triangles[3 * t]), (into[at + 1] = triangles[3 * t + 1]), (into[at + 2] = triangles[3 * t + 2]));
      into[at + 3] = triangleMaterials[t];
    });
    /** @type {number} scene time of the moving vertices, microseconds; -1: none */
    this.time = -1;
  }

  /** The textures, as uniforms of shaders/frame.js. */
  get uniforms() {
    return { vertices: this.vertices, normals: this.normals, triangles: this.triangles };
  }

  /** Brings what moves to its place. Returns whether anything has changed. */
  pose(/** @type {number} */ us) {
    if (us === this.time) return false;
    this.time = us;
    const { pack, motion } = this;
    if (motion.instances.length === 0) return false;
    const toWorld = motion.transforms(us);
    const firstVertex = pack.info.resting.vertices,
      firstTriangle = pack.info.resting.triangles;
    const moved = new Moved(pack, firstVertex, firstTriangle);
    for (const instance of motion.instances) poseInstance(pack, instance, toWorld[instance.node], moved);
    this.vertices.put(firstVertex, moved.vertices);
    this.normals.put(firstVertex, moved.normals);
    this.triangles.put(firstTriangle, moved.triangles);
    return true;
  }

  /** The first so many triangles never move. */
  get restingTriangles() {
    return this.pack.info.resting.triangles;
  }

  /** Whether instances move: lights alone leave the picture's surfaces where they are. */
  get surfacesMove() {
    return this.motion.instances.length > 0;
  }

  dispose(/** @type {WebGL2RenderingContext} */ gl) {
    for (const list of [this.vertices, this.normals, this.triangles]) gl.deleteTexture(list.texture);
  }
}

/** What poseInstance writes into, in the form of the lists. */
class Moved {
  constructor(
    /** @type {import('../pack/pack.js').ScenePack} */ pack,
    /** @type {number} */ firstVertex,
    /** @type {number} */ firstTriangle,
  ) {
    this.pack = pack;
    this.firstVertex = firstVertex;
    this.firstTriangle = firstTriangle;
    this.vertices = new Float32Array(4 * (pack.vertexCount - firstVertex));
    this.normals = new Float32Array(4 * (pack.vertexCount - firstVertex));
    this.triangles = new Uint32Array(4 * (pack.triangleCount - firstTriangle));
  }

  position(/** @type {number} */ v, /** @type {number} */ x, /** @type {number} */ y, /** @type {number} */ z) {
    this.vertices.set([x, y, z, this.pack.uvs[2 * v]], 4 * (v - this.firstVertex));
  }

  normal(/** @type {number} */ v, /** @type {number} */ x, /** @type {number} */ y, /** @type {number} */ z) {
    this.normals.set([x, y, z, this.pack.uvs[2 * v + 1]], 4 * (v - this.firstVertex));
  }

  triangle(/** @type {number} */ t, /** @type {number} */ a, /** @type {number} */ b, /** @type {number} */ c) {
    this.triangles.set([a, b, c, this.pack.triangleMaterials[t]], 4 * (t - this.firstTriangle));
  }
}
