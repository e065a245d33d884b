// gpu/shaders/raster.glsl, for devices whose grid is not the server's: triangles are drawn a little too wide, and each
// fragment tests in integers whether its pixel's centre lies in the outline whose corners are rounded to 1/256 of a pixel.
// Its depth comes from the triangle's plane, as the server's does, the nearest being 1.
import { ALPHA, SCENE } from './frame.js';

// The sign of (b - a) x (p - a), exactly. Floats decide unless they are too near to zero.
const TURN = `
// The product of two numbers of at most 31 bits, as 64 bits: the low and the high half.
uvec2 product(int a, int b) {
  uint x = uint(abs(a)), y = uint(abs(b));
  uint low = (x & 0xffffu) * (y & 0xffffu), high = (x >> 16) * (y >> 16);
  uint middle = (x >> 16) * (y & 0xffffu) + (x & 0xffffu) * (y >> 16);
  uvec2 whole = uvec2(low + (middle << 16), high + (middle >> 16));
  if (whole.x < low) ++whole.y;
  if ((a < 0) == (b < 0)) return whole;
  return uvec2(~whole.x + 1u, ~whole.y + (whole.x == 0u ? 1u : 0u));
}

int turn(ivec2 a, ivec2 b, ivec2 p) {
  ivec2 u = b - a, v = p - a;
  vec2 terms = vec2(u) * vec2(v.yx);
  float difference = terms.x - terms.y;
  if (abs(difference) > 1e-6 * (abs(terms.x) + abs(terms.y))) return difference > 0.0 ? 1 : -1;
  uvec2 left = product(u.x, v.y), right = product(u.y, v.x);
  if (left == right) return 0;
  bool less = left.y == right.y ? left.x < right.x : int(left.y) < int(right.y);
  return less ? -1 : 1;
}
`;

export const OUTLINE_VERTEX =
  SCENE +
  TURN +
  `
uniform mat4 camera_to_clip;
uniform vec3 camera;
uniform vec3 ray_corner;
uniform vec3 ray_dx;
uniform vec3 ray_dy;
uniform float near_plane;
uniform vec2 picture_size;
uniform float widening;  // pixels by which the device's rounding may move an edge
uniform bool one_sided;
uniform uint first_triangle;
flat out uint triangle;
flat out ivec4 outline_ab;  // corners in grid points, ordered so that turn() is positive inside
flat out ivec2 outline_c;
flat out vec3 plane;        // depth: at the first pixel, and its steps
flat out vec3 range;        // nearest and farthest depth; 1 where the outline is the device's

ivec2 to_grid(vec4 clip) {
  vec2 grid = floor((clip.xy / clip.w * 0.5 + 0.5) * picture_size * 256.0 + 0.5);
  return ivec2(clamp(grid, vec2(-536870912.0), vec2(536870912.0)));
}

// Where a corner has to be for both of its edges to be moved outwards.
vec2 widened(vec2 before, vec2 at, vec2 after) {
  vec2 u = normalize(at - before), v = normalize(after - at);
  vec2 way = (u - v) / max(u.x * v.y - u.y * v.x, 1e-6);
  return way * min(widening, 64.0 / length(way));  // the tips of needles are cut off
}

void main() {
  triangle = first_triangle + uint(gl_VertexID) / 3u;
  uvec3 vertex = triangle_of(triangle).xyz;
  vec3 a = position_of(vertex.x) - camera, b = position_of(vertex.y) - camera, c = position_of(vertex.z) - camera;
  vec4 clip[3] = vec4[3](camera_to_clip * vec4(a, 1.0), camera_to_clip * vec4(b, 1.0), camera_to_clip * vec4(c, 1.0));
  vec3 normal = cross(b - a, c - a);
  float height = dot(normal, a);
  float shallow = min(clip[0].w, min(clip[1].w, clip[2].w)), deep = max(clip[0].w, max(clip[1].w, clip[2].w));
  range = vec3(shallow > near_plane ? near_plane / shallow : 1.0, near_plane / max(deep, near_plane), 0.0);
  plane = vec3(range.x, 0.0, 0.0);
  if (height != 0.0)
    plane = near_plane / height * vec3(dot(normal, ray_corner + 0.5 * (ray_dx + ray_dy)), dot(normal, ray_dx),
                                       dot(normal, ray_dy));
  outline_ab = ivec4(0), outline_c = ivec2(0);
  int corner = gl_VertexID % 3;
  gl_Position = clip[corner];
  if (shallow < near_plane) {  // the near plane cuts it, as far as it is seen at all
    range.z = 1.0;
    if (one_sided && height >= 0.0) gl_Position = vec4(0.0, 0.0, 0.0, -1.0);
    return;
  }
  ivec2 at[3] = ivec2[3](to_grid(clip[0]), to_grid(clip[1]), to_grid(clip[2]));
  int area = turn(at[0], at[1], at[2]);
  if (area == 0 || (area > 0 && one_sided)) {
    gl_Position = vec4(0.0, 0.0, 0.0, -1.0);  // for all three corners: nothing is drawn
    return;
  }
  int step = area > 0 ? 1 : 2;
  outline_ab = ivec4(at[0], at[step]);
  outline_c = at[3 - step];
  vec2 out_by = widened(vec2(at[(corner + 3 - step) % 3]) / 256.0, vec2(at[corner]) / 256.0,
                        vec2(at[(corner + step) % 3]) / 256.0);
  gl_Position.xy += 2.0 * out_by / picture_size * gl_Position.w;
}
`;

export const OUTLINE_FRAGMENT =
  SCENE +
  ALPHA +
  TURN +
  `
uniform vec3 camera;
uniform vec3 ray_corner;
uniform vec3 ray_dx;
uniform vec3 ray_dy;
flat in uint triangle;
flat in ivec4 outline_ab;
flat in ivec2 outline_c;
flat in vec3 plane;
flat in vec3 range;
out uint triangle_id;

// A centre that lies on an edge belongs to one of the two triangles there, by the top-left rule.
bool within(ivec2 from, ivec2 to, ivec2 middle) {
  ivec2 along = to - from;
  bool owns_edge = along.y < 0 || (along.y == 0 && along.x >= 0);
  return turn(from, to, middle) >= (owns_edge ? 0 : 1);
}

#ifdef MASKED
bool solid_at(ivec2 pixel) {
  uvec4 corners = triangle_of(triangle);
  vec3 a = position_of(corners.x) - camera, b = position_of(corners.y) - camera, c = position_of(corners.z) - camera;
  vec3 ray = ray_corner + (float(pixel.x) + 0.5) * ray_dx + (float(pixel.y) + 0.5) * ray_dy;
  vec3 weights = vec3(dot(cross(b, c), ray), dot(cross(c, a), ray), dot(cross(a, b), ray));
  weights /= weights.x + weights.y + weights.z;
  vec2 uv = weights.x * uv_of(corners.x) + weights.y * uv_of(corners.y) + weights.z * uv_of(corners.z);
  return passes_alpha_test(material_of(corners.w), uv);
}
#endif

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy), middle = 256 * pixel + 128;
  if (range.z == 0.0 && !(within(outline_ab.xy, outline_ab.zw, middle) && within(outline_ab.zw, outline_c, middle) &&
                          within(outline_c, outline_ab.xy, middle))) discard;
#ifdef MASKED
  if (!solid_at(pixel)) discard;
#endif
  gl_FragDepth = clamp(plane.x + float(pixel.x) * plane.y + float(pixel.y) * plane.z, range.y, range.x);
  triangle_id = triangle + 1u;
}
`;
