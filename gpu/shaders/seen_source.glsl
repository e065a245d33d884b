// Finds the pixel of a view seen before that shows a surface.
#include "seen_view.glsl"

// Whether the seen view shows in pixel `at` the surface `here`: the same side of a surface, with each of the two points
// no farther from the other's plane than a pixel's width there (`reach`).
bool shows(SeenView seen, Uints ids, uvec2 at, SurfacePoint here, float reach) {
  uint id = ids.at[at.y * seen.width + at.x];
  if (id == 0u) return false;
  uvec3 corners = frame.triangles.at[id - 1u];
  vec3 ray = seen.ray_corner + (float(at.x) + 0.5) * seen.ray_dx + (float(at.y) + 0.5) * seen.ray_dy;
  SurfacePoint there = surface_point(seen.eye, seen.forward, ray, frame.positions.at[corners.x],
                                     frame.positions.at[corners.y], frame.positions.at[corners.z]);
  vec3 apart = there.position - here.position;
  return dot(here.normal, there.normal) > 0.5 && abs(dot(apart, here.normal)) <= reach &&
         abs(dot(apart, there.normal)) <= reach;
}

// Returns 1 + the seen view's pixel, counted row by row; 0 if it does not show this surface. It tries the pixel that
// the point falls into, then the other three of the four pixels around the point, because at an edge the pixel's sample
// may have hit a neighbouring surface.
uint source_of(SeenView seen, Uints ids, SurfacePoint here) {
  vec3 from_eye = here.position - seen.eye;
  float depth = dot(from_eye, seen.forward);
  if (!(depth > 0.0)) return 0u;
  vec3 beside = from_eye / depth - seen.ray_corner;
  vec2 place = vec2(dot(beside, seen.across), dot(beside, seen.down));
  ivec2 size = ivec2(seen.width, seen.height);
  if (any(lessThan(place, vec2(0.0))) || any(greaterThanEqual(place, vec2(size)))) return 0u;
  ivec2 nearest = min(ivec2(place), size - 1);
  ivec2 towards = mix(ivec2(-1), ivec2(1), greaterThanEqual(fract(place), vec2(0.5)));
  uint beside_it = 0u;
  for (int i = 0; i < 4; ++i) {
    ivec2 at = nearest + towards * ivec2(i & 1, i >> 1);
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, size))) continue;
    uint number = uint(at.y * size.x + at.x);
    if (shows(seen, ids, uvec2(at), here, depth * seen.pixel)) return 1u + number;
    if (beside_it == 0u && ids.at[number] != 0u) beside_it = 1u + number;
  }
  return seen.same_eye != 0u ? beside_it : 0u;
}
