// gpu/shaders/predict.comp: the pixel of a view seen before that shows the same surface.
export const PREDICT = `
uniform usampler2D seen_ids;
uniform vec3 seen_eye;
uniform vec3 seen_forward;
uniform vec3 seen_ray_corner;
uniform vec3 seen_ray_dx;
uniform vec3 seen_ray_dy;
uniform vec3 seen_across;  // seen_ray_dx / |seen_ray_dx|^2; seen_down likewise of seen_ray_dy
uniform vec3 seen_down;
uniform float seen_pixel;  // width of a pixel at depth 1
uniform ivec2 seen_size;
uniform bool same_eye;

// Whether the seen view shows in pixel \`at\` the surface \`here\`: the same side of a surface, with each of the two points
// no farther from the other's plane than a pixel's width there (\`reach\`).
bool shows(ivec2 at, uint id, SurfacePoint here, float reach) {
  uvec4 corners = triangle_of(id - 1u);
  vec3 ray = seen_ray_corner + (float(at.x) + 0.5) * seen_ray_dx + (float(at.y) + 0.5) * seen_ray_dy;
  SurfacePoint there = surface_point(seen_eye, seen_forward, ray, position_of(corners.x), position_of(corners.y),
                                     position_of(corners.z));
  vec3 apart = there.position - here.position;
  return dot(here.normal, there.normal) > 0.5 && abs(dot(apart, here.normal)) <= reach &&
         abs(dot(apart, there.normal)) <= reach;
}

const ivec2 kNowhere = ivec2(-1);

// The seen view's pixel; kNowhere if it does not show this surface. It tries the pixel that the point falls into, then
// the other three of the four pixels around the point, because at an edge the pixel's sample may have hit a neighbouring
// surface.
ivec2 source_of(SurfacePoint here) {
  vec3 from_eye = here.position - seen_eye;
  float depth = dot(from_eye, seen_forward);
  if (!(depth > 0.0)) return kNowhere;
  vec3 beside = from_eye / depth - seen_ray_corner;
  vec2 place = vec2(dot(beside, seen_across), dot(beside, seen_down));
  if (any(lessThan(place, vec2(0.0))) || any(greaterThanEqual(place, vec2(seen_size)))) return kNowhere;
  ivec2 nearest = min(ivec2(place), seen_size - 1);
  vec2 part = fract(place);
  ivec2 towards = ivec2(part.x >= 0.5 ? 1 : -1, part.y >= 0.5 ? 1 : -1);
  ivec2 beside_it = kNowhere;
  for (int i = 0; i < 4; ++i) {
    ivec2 at = nearest + towards * ivec2(i & 1, i >> 1);
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, seen_size))) continue;
    uint id = texelFetch(seen_ids, at, 0).x;
    if (id == 0u) continue;
    if (shows(at, id, here, depth * seen_pixel)) return at;
    if (beside_it.x < 0) beside_it = at;
  }
  return same_eye ? beside_it : kNowhere;
}
`;
