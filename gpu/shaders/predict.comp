#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "surface.glsl"

#include "seen_view.glsl"

// Finds for each pixel the pixel of a view seen before that shows the same surface.
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Sources { uint at[]; };
layout(push_constant, scalar) uniform Push {
  SeenView seen;
  Uints seen_ids;  // triangle_id of that view
  Uints ids;       // triangle_id of this view
  Sources sources;
} push;

// Whether the seen view shows in pixel `at` the surface `here`: the same side of a surface, with each of the two points
// no farther from the other's plane than a pixel's width there (`reach`).
bool shows(uvec2 at, SurfacePoint here, float reach) {
  uint id = push.seen_ids.at[at.y * push.seen.width + at.x];
  if (id == 0u) return false;
  uvec3 corners = frame.triangles.at[id - 1u];
  vec3 ray = push.seen.ray_corner + (float(at.x) + 0.5) * push.seen.ray_dx + (float(at.y) + 0.5) * push.seen.ray_dy;
  SurfacePoint there = surface_point(push.seen.eye, push.seen.forward, ray, frame.positions.at[corners.x],
                                     frame.positions.at[corners.y], frame.positions.at[corners.z]);
  vec3 apart = there.position - here.position;
  return dot(here.normal, there.normal) > 0.5 && abs(dot(apart, here.normal)) <= reach &&
         abs(dot(apart, there.normal)) <= reach;
}

// Returns 1 + the seen view's pixel, counted row by row; 0 if it does not show this surface. It tries the pixel that
// the point falls into, then the other three of the four pixels around the point, because at an edge the pixel's sample
// may have hit a neighbouring surface.
uint source_of(SurfacePoint here) {
  vec3 from_eye = here.position - push.seen.eye;
  float depth = dot(from_eye, push.seen.forward);
  if (!(depth > 0.0)) return 0u;
  vec3 beside = from_eye / depth - push.seen.ray_corner;
  vec2 place = vec2(dot(beside, push.seen.across), dot(beside, push.seen.down));
  ivec2 size = ivec2(push.seen.width, push.seen.height);
  if (any(lessThan(place, vec2(0.0))) || any(greaterThanEqual(place, vec2(size)))) return 0u;
  ivec2 nearest = min(ivec2(place), size - 1);
  ivec2 towards = mix(ivec2(-1), ivec2(1), greaterThanEqual(fract(place), vec2(0.5)));
  uint beside_it = 0u;
  for (int i = 0; i < 4; ++i) {
    ivec2 at = nearest + towards * ivec2(i & 1, i >> 1);
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, size))) continue;
    uint number = uint(at.y * size.x + at.x);
    if (shows(uvec2(at), here, depth * push.seen.pixel)) return 1u + number;
    if (beside_it == 0u && push.seen_ids.at[number] != 0u) beside_it = 1u + number;
  }
  return push.seen.same_eye != 0u ? beside_it : 0u;
}

void main() {
  uvec2 pixel = gl_WorkGroupID.xy * 8u + pixel_in_tile(gl_LocalInvocationIndex);
  if (pixel.x >= frame.width || pixel.y >= frame.height) return;
  uint index = pixel.y * frame.width + pixel.x;
  uint id = push.ids.at[index];
  uint source = 0u;
  if (id != 0u) source = source_of(surface_of(id - 1u, pixel));
  push.sources.at[index] = source;
}
