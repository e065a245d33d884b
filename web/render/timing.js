// How long the device works, where the browser tells: EXT_disjoint_timer_query_webgl2. Answers come frames later.
export class Timing {
  constructor(/** @type {WebGL2RenderingContext} */ gl) {
    this.gl = gl;
    this.extension = gl.getExtension('EXT_disjoint_timer_query_webgl2');
    /** @type {{query: WebGLQuery, name: string}[]} */
    this.asked = [];
    /** @type {Record<string, number>} newest milliseconds of each part */
    this.ms = {};
  }

  /** Measures what `work` has the device do. Parts must not lie within each other. */
  measure(/** @type {string} */ name, /** @type {() => void} */ work) {
    const { gl, extension } = this;
    // Few at a time: a browser in the background answers none.
    if (!extension || this.asked.length > 8) return work();
    const query = /** @type {WebGLQuery} */ (gl.createQuery());
    gl.beginQuery(extension.TIME_ELAPSED_EXT, query);
    work();
    gl.endQuery(extension.TIME_ELAPSED_EXT);
    this.asked.push({ query, name });
  }

  /** Takes the answers that are there. */
  collect() {
    const { gl, extension } = this;
    if (!extension) return;
    const disjoint = gl.getParameter(extension.GPU_DISJOINT_EXT);
    this.asked = this.asked.filter(({ query, name }) => {
      if (!disjoint && !gl.getQueryParameter(query, gl.QUERY_RESULT_AVAILABLE)) return true;
      if (!disjoint) this.ms[name] = gl.getQueryParameter(query, gl.QUERY_RESULT) / 1e6;
      gl.deleteQuery(query);
      return false;
    });
  }
}
