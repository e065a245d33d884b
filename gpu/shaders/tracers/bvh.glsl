// Walks a bounding volume hierarchy without a stack: nodes are in depth-first order, and a miss follows `skip`
// (gpu/builds/bvh.h). The result is bit-identical to testing every triangle, because a box is met whenever one
// of its triangles is. The includer defines struct Hierarchy; first_triangle is added to the numbers of its triangles.
#include "tracers/alpha.glsl"

struct BvhNode {
  vec3 lo;
  uint skip;
  vec3 hi;
  uint leaf;
};
struct BvhTriangle {
  vec3 p0;
  uint triangle;
  vec3 p1;
  uint masked;
  vec3 p2;
  uint reserved;
};
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer BvhNodes { BvhNode at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer BvhTriangles { BvhTriangle at[]; };

bool triangle_blocks(BvhTriangle t, uint first_triangle, vec3 origin, vec3 direction) {
  if (!segment_meets_triangle(origin, direction, t.p0, t.p1, t.p2)) return false;
  return t.masked == 0u || blocks_by_alpha(first_triangle + t.triangle, origin, direction, t.p0, t.p1, t.p2);
}

bool leaf_blocks(Hierarchy h, uint leaf, vec3 origin, vec3 direction) {
  uint first = leaf >> 4, count = leaf & 15u;
  for (uint i = 0u; i < count; ++i)
    if (triangle_blocks(BvhTriangles(h.triangles).at[first + i], h.first_triangle, origin, direction)) return true;
  return false;
}

bool meets(Hierarchy h, vec3 origin, vec3 direction) {
  // No component is zero, so no product below is 0 * infinity.
  vec3 tiny = vec3(1e-20);
  vec3 slope = 1.0 / mix(direction, tiny, lessThan(abs(direction), tiny));
  uint n = 0u;
  while (n < h.node_count) {
    BvhNode node = BvhNodes(h.nodes).at[n];
    // A hit may lie outside its triangle's box by 1/4096 of the box's farthest coordinate, seen from the origin
    // (segment_meets_triangle): the box is widened by a little more, rounding included.
    vec3 lo = node.lo - origin, hi = node.hi - origin;
    vec3 reach = max(abs(lo), abs(hi));
    float margin = max(reach.x, max(reach.y, reach.z)) * (1.0 / 4095.0);
    vec3 t0 = (lo - margin) * slope;
    vec3 t1 = (hi + margin) * slope;
    vec3 near = min(t0, t1), far = max(t0, t1);
    float enter = max(max(near.x, near.y), max(near.z, 0.0));
    float leave = min(min(far.x, far.y), min(far.z, 1.0));
    bool met = enter <= leave * 1.000001;
    if (met && node.leaf != 0u && leaf_blocks(h, node.leaf, origin, direction)) return true;
    n = met ? n + 1u : node.skip;
  }
  return false;
}
