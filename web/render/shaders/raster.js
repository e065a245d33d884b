// gpu/shaders/gbuffer.glsl and gbuffer_masked.frag: the number of the triangle that each pixel shows. The shader fetches
// the corners itself, so that each has its triangle's number.
import { ALPHA, SCENE } from './frame.js';

export const RASTER_VERTEX =
  SCENE +
  `
uniform mat4 camera_to_clip;
uniform vec3 camera;
uniform uint first_triangle;
flat out uint triangle;
out vec2 surface_uv;

void main() {
  triangle = first_triangle + uint(gl_VertexID) / 3u;
  uvec3 corners = triangle_of(triangle).xyz;
  int corner = gl_VertexID % 3;
  uint vertex = corner == 0 ? corners.x : corner == 1 ? corners.y : corners.z;
#ifdef MASKED
  surface_uv = uv_of(vertex);
#endif
  // Relative to the camera first: large world coordinates cancel exactly.
  gl_Position = camera_to_clip * vec4(position_of(vertex) - camera, 1.0);
}
`;

export const RASTER_FRAGMENT =
  SCENE +
  ALPHA +
  `
flat in uint triangle;
in vec2 surface_uv;
#ifndef DEPTH_ALONE
out uint triangle_id;
#endif

void main() {
#ifdef MASKED
  if (!passes_alpha_test(material_of(triangle_of(triangle).w), surface_uv)) discard;
#endif
#ifndef DEPTH_ALONE
  triangle_id = triangle + 1u;
#endif
}
`;
