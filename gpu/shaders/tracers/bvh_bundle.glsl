// Walks a hierarchy for all segments from a surface to the points of an area light, in one walk where the light is small for
// its distance (shaft culling: Haines and Wallace, "Shaft Culling for Efficient Ray-Traced Radiosity", 1991). The counts
// are those of tracing each segment by itself, as a box is met whenever one of its triangles is, and triangles that do
// not hide or miss the whole light are tested segment by segment. Includes what declares `push` with a soft frame, and
// kLooksAtPoints, before.
#include "light_bundle.glsl"
#include "tracers/bvh.glsl"

// One over the least and over the most that directions to points of the light are in each coordinate: at t of its way a
// segment is between t * least and t * most. No component is infinite.
struct Shaft {
  vec3 by_least, by_most;
};

vec3 inverse_of(vec3 direction) {
  vec3 tiny = vec3(1e-20);
  return 1.0 / mix(direction, tiny, lessThan(abs(direction), tiny));
}

Shaft shaft_of(Bundle bundle) {
  vec3 middle = bundle.origin + bundle.to_middle;
  vec3 reach = vec3(1.001 * bundle.radius + 1e-5 * sum_of(bundle.to_middle) + 1e-6 * sum_of(middle));
  return Shaft(inverse_of(bundle.to_middle - reach), inverse_of(bundle.to_middle + reach));
}

// Whether at some t from 0 to 1 the shaft reaches into the box, whose corners are relative to the origin: in each
// coordinate, t * least is at most hi, and t * most at least lo.
bool shaft_meets(Shaft shaft, vec3 lo, vec3 hi) {
  vec3 below = hi * shaft.by_least, above = lo * shaft.by_most, none = vec3(0.0), all = vec3(1.0);
  vec3 enter = max(mix(none, below, lessThan(shaft.by_least, none)), mix(none, above, greaterThan(shaft.by_most, none)));
  vec3 leave = min(mix(all, below, greaterThan(shaft.by_least, none)), mix(all, above, lessThan(shaft.by_most, none)));
  return max(enter.x, max(enter.y, max(enter.z, 0.0))) <= min(leave.x, min(leave.y, min(leave.z, 1.0))) * 1.000001;
}

uint open_behind_in_one_walk(Tree tree, Bundle bundle, uint open) {
  Shaft shaft = shaft_of(bundle);
  SeenPoints points = points_anywhere();
  if (kLooksAtPoints) points = points_as_seen(bundle.origin, bundle.to_middle, bundle.radius, bundle.first);
  uint n = 0u;
  while (n < tree.at.node_count && open != 0u) {
    BvhNode node = node_at(tree, n);
    vec3 lo = node.lo - bundle.origin, hi = node.hi - bundle.origin;
    vec3 reach = max(abs(lo), abs(hi));
    float margin = max(reach.x, max(reach.y, reach.z)) * (1.0 / 4095.0);  // as meets() has it
    bool met = shaft_meets(shaft, lo - margin, hi + margin);
    uint first = node.leaf >> 4, count = met ? node.leaf & 15u : 0u;
    for (uint i = 0u; i < count && open != 0u; ++i) {
      BvhTriangle t = bvh_triangle_at(tree, first + i);
      open = left_open(bundle, points, open, Occluder(tree.at.first_triangle + t.triangle, t.masked != 0u, t.p0, t.p1, t.p2));
    }
    n = met ? n + 1u : node.skip;
  }
  return open;
}

uint open_behind_by_walks(Tree tree, Bundle bundle, uint open) {
  for (uint asked = open; asked != 0u; asked &= asked - 1u) {
    uint bit = uint(findLSB(asked));
    if (meets(tree, bundle.origin, direction_to(bundle, point_of(bit)))) open &= ~(1u << bit);
  }
  return open;
}

// Into a wide shaft, and before the lamp that a light hangs in, much reaches that no segment meets: with 4 points, or a
// light nearer than so many radii, walks of their own were faster (docs/soft-light.md).
const float kNarrow = 64.0;
const uint kWorthOneWalk = 16u;

// The points of `open` that the hierarchy's geometry does not hide.
uint open_behind(Tree tree, Bundle bundle, uint open) {
  if (tree.at.node_count == 0u) return open;
  bool narrow = dot(bundle.to_middle, bundle.to_middle) > kNarrow * kNarrow * bundle.radius * bundle.radius;
  return narrow && push.soft.samples >= kWorthOneWalk ? open_behind_in_one_walk(tree, bundle, open)
                                                      : open_behind_by_walks(tree, bundle, open);
}
