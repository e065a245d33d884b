// All segments from a surface to the points of an area light. Includes what declares `push` with a soft frame before.
#include "seen_before_light.glsl"
#include "seen_points.glsl"
#include "tracers/alpha.glsl"

struct Bundle {
  vec3 origin;
  vec3 to_middle;  // of the light
  float radius;    // no point is farther from the middle
  uint first;      // of the points
};

vec3 direction_to(Bundle bundle, uint i) {
  return sample_segment(bundle.origin, vec3(0.0), SAMPLE_POINT(bundle.first + i)).direction;
}

// The points in front of the surface. Where the whole light is, with room for all rounding, no point is looked at.
uint facing_points(Bundle bundle, vec3 normal) {
  uint samples = push.soft.samples;
  if (dot(normal, bundle.to_middle) > 1.001 * bundle.radius + 1e-5 * sum_of(bundle.to_middle)) return all_points(samples);
  uint facing = 0u;
  for (uint i = 0u; i < samples; ++i)
    facing |= sample_segment(bundle.origin, normal, SAMPLE_POINT(bundle.first + i)).traced ? point_bit(i) : 0u;
  return facing;
}

struct Occluder {
  uint triangle;
  bool masked;
  vec3 p0, p1, p2;
};

// The points of `open` that the triangle does not hide.
uint left_open(Bundle bundle, SeenPoints points, uint open, Occluder o) {
  uint behind = open & points_behind(points, o.p0 - bundle.origin, o.p1 - bundle.origin, o.p2 - bundle.origin);
  if (behind == 0u) return open;
  SeenTriangle seen = seen_triangle(bundle.origin, o.p0, o.p1, o.p2);
  uint before = seen_before_light(seen, bundle.to_middle, bundle.radius);
  uint hidden = before == kHidesLight ? open : 0u;
  if (before == kCutsLight) {
    for (uint i = 0u; i < push.soft.samples; ++i) {
      uint bit = point_bit(i);
      if ((behind & bit) != 0u && meets_seen_triangle(seen, direction_to(bundle, i))) hidden |= bit;
    }
  }
  for (uint asked = o.masked ? hidden : 0u; asked != 0u; asked &= asked - 1u) {
    uint bit = uint(findLSB(asked));
    vec3 direction = direction_to(bundle, point_of(bit));
    if (!blocks_by_alpha(o.triangle, bundle.origin, direction, o.p0, o.p1, o.p2)) hidden &= ~(1u << bit);
  }
  return open & ~hidden;
}
