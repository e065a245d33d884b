// Reads a scene pack (web/PACK.md). The sections stay where they lie in the pack's bytes: nothing is copied.

/**
 * @typedef {{offset: number, bytes: number}} Section
 * @typedef {{first_triangle: number, triangles: number, masked: boolean, double_sided: boolean}} Group
 * @typedef {{name: string, base_color: number[], emissive: number[], texture: number, alpha_mode: string,
 *   alpha_cutoff: number, double_sided: boolean}} Material
 * @typedef {{width: number, height: number, wrap_u: string, wrap_v: string, has_alpha: boolean, type: string,
 *   offset: number, bytes: number}} TextureEntry
 */

const MAGIC = 'GNPACK01';
const HEADER_BYTES = 16;

/** What is wrong with a pack, or with its way here, as a sentence for people. */
export class PackError extends Error {}

/** A scene as it lies in its pack. `info` is the pack's JSON. */
export class ScenePack {
  /** @param {ArrayBuffer} buffer the whole pack, unpacked */
  constructor(buffer) {
    this.buffer = buffer;
    this.info = readHeader(buffer);
    const { sections } = this.info;
    /** Of each vertex: three numbers, three, two. */
    this.positions = this.floats(sections.positions);
    this.normals = this.floats(sections.normals);
    this.uvs = this.floats(sections.uvs);
    /** Of each triangle: its three vertices, its material. */
    this.triangles = this.words(sections.triangles);
    this.triangleMaterials = this.words(sections.triangle_materials);
    this.vertexCount = this.positions.length / 3;
    this.triangleCount = this.triangles.length / 3;
    this.check();
  }

  /** @param {Section} section */
  floats(section) {
    return new Float32Array(this.buffer, ...this.range(section));
  }

  /** @param {Section} section */
  words(section) {
    return new Uint32Array(this.buffer, ...this.range(section));
  }

  /**
   * @param {Section} section
   * @returns {[number, number]}
   */
  range(section) {
    if (
      !section ||
      section.offset % 4 !== 0 ||
      !(section.offset >= 0 && section.bytes >= 0) ||
      section.bytes % 4 !== 0 ||
      section.offset + section.bytes > this.buffer.byteLength
    )
      throw new PackError('The scene is damaged: a section lies outside of it.');
    return [section.offset, section.bytes / 4];
  }

  /** Lists that do not fit to each other would be read beyond their ends by shaders, where no error says so. */
  check() {
    const fits =
      this.normals.length === 3 * this.vertexCount &&
      this.uvs.length === 2 * this.vertexCount &&
      this.triangleMaterials.length === this.triangleCount &&
      Number.isInteger(this.vertexCount) &&
      Number.isInteger(this.triangleCount);
    if (!fits) throw new PackError('The scene is damaged: its lists are of different lengths.');
    const materials = this.info.materials.length;
    if (
      this.triangles.some((vertex) => vertex >= this.vertexCount) ||
      this.triangleMaterials.some((material) => material >= materials)
    )
      throw new PackError('The scene is damaged: a triangle names what is not there.');
  }

  /**
   * Decodes the image of a texture: its bytes as they are, neither converted to another colour space nor multiplied by
   * their alpha.
   * @param {TextureEntry} texture
   * @returns {Promise<ImageBitmap>}
   */
  async image(texture) {
    const bytes = new Uint8Array(this.buffer, texture.offset, texture.bytes);
    const blob = new Blob([bytes], { type: texture.type });
    return createImageBitmap(blob, { colorSpaceConversion: 'none', premultiplyAlpha: 'none' });
  }
}

/** @param {ArrayBuffer} buffer */
function readHeader(buffer) {
  const view = new DataView(buffer);
  if (buffer.byteLength < HEADER_BYTES || text(buffer, 0, 8) !== MAGIC)
    throw new PackError('This is no scene that this page can read. Reload the page: it may be older than the server.');
  const bytes = view.getUint32(8, true);
  if (HEADER_BYTES + bytes > buffer.byteLength) throw new PackError('The scene is damaged: it ends too early.');
  try {
    return JSON.parse(text(buffer, HEADER_BYTES, bytes));
  } catch {
    throw new PackError('The scene is damaged: its description cannot be read.');
  }
}

/**
 * @param {ArrayBuffer} buffer
 * @param {number} offset
 * @param {number} bytes
 */
function text(buffer, offset, bytes) {
  return new TextDecoder().decode(new Uint8Array(buffer, offset, bytes));
}

/**
 * Downloads a pack: its bytes, for ScenePack. `bytes`, if it is known, is the pack's unpacked length: a compressed answer
 * does not say it.
 * @param {string} url
 * @param {{headers?: HeadersInit, bytes?: number, signal?: AbortSignal,
 *   onProgress?: (done: number, total: number) => void}} options `total` is 0 where it is unknown
 * @returns {Promise<ArrayBuffer>}
 */
export async function fetchPack(url, { headers, bytes = 0, signal, onProgress = () => {} } = {}) {
  const response = await fetch(url, { headers, signal });
  if (!response.ok) throw new PackError(`The scene cannot be had: the server answered ${response.status}.`);
  const packed = response.headers.has('Content-Encoding');
  const total = bytes || (packed ? 0 : Number(response.headers.get('Content-Length')) || 0);
  return readAll(response, total, onProgress);
}

/**
 * @param {Response} response
 * @param {number} total
 * @param {(done: number, total: number) => void} onProgress
 */
async function readAll(response, total, onProgress) {
  if (!response.body) return response.arrayBuffer();
  const reader = response.body.getReader();
  let whole = new Uint8Array(total || 1 << 20);
  let done = 0;
  for (;;) {
    const next = await reader.read();
    if (next.done) break;
    if (done + next.value.length > whole.length) {
      const larger = new Uint8Array(Math.max(2 * whole.length, done + next.value.length));
      larger.set(whole.subarray(0, done));
      whole = larger;
    }
    whole.set(next.value, done);
    done += next.value.length;
    onProgress(done, total);
  }
  return done === whole.length ? whole.buffer : whole.buffer.slice(0, done);
}
