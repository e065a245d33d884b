// Walks a bounding volume hierarchy without a stack: nodes are in depth-first order, and a miss follows `skip`
// (gpu/builds/bvh.h). The result is bit-identical to testing every triangle, because a box is met whenever one
// of its triangles is. The includer defines struct Hierarchy; first_triangle is added to the numbers of its triangles.
#include "pairs.glsl"
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
#ifdef BY_PAIRS

struct NodePairs {
  uint64_t a, b, c, d;
};
struct TrianglePairs {
  uint64_t a, b, c, d, e, f;
};
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer BvhNodes { NodePairs at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer BvhTriangles { TrianglePairs at[]; };

BvhNode node_at(uvec2 nodes, uint n) {
  NodePairs node = BvhNodes(nodes).at[n];
  vec2 a = floats_of(node.a), b = floats_of(node.b), c = floats_of(node.c), d = floats_of(node.d);
  return BvhNode(vec3(a, b.x), floatBitsToUint(b.y), vec3(c, d.x), floatBitsToUint(d.y));
}

BvhTriangle bvh_triangle_at(uvec2 triangles, uint n) {
  TrianglePairs t = BvhTriangles(triangles).at[n];
  vec2 a = floats_of(t.a), b = floats_of(t.b), c = floats_of(t.c), d = floats_of(t.d), e = floats_of(t.e);
  return BvhTriangle(vec3(a, b.x), floatBitsToUint(b.y), vec3(c, d.x), floatBitsToUint(d.y),
                     vec3(e, floats_of(t.f).x), 0u);
}

#else

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer BvhNodes { BvhNode at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer BvhTriangles { BvhTriangle at[]; };

BvhNode node_at(uvec2 nodes, uint n) { return BvhNodes(nodes).at[n]; }
BvhTriangle bvh_triangle_at(uvec2 triangles, uint n) { return BvhTriangles(triangles).at[n]; }

#endif

bool triangle_blocks(BvhTriangle t, uint first_triangle, vec3 origin, vec3 direction) {
  if (!segment_meets_triangle(origin, direction, t.p0, t.p1, t.p2)) return false;
  return t.masked == 0u || blocks_by_alpha(first_triangle + t.triangle, origin, direction, t.p0, t.p1, t.p2);
}

bool leaf_blocks(Hierarchy h, uint leaf, vec3 origin, vec3 direction) {
  uint first = leaf >> 4, count = leaf & 15u;
  for (uint i = 0u; i < count; ++i)
    if (triangle_blocks(bvh_triangle_at(h.triangles, first + i), h.first_triangle, origin, direction)) return true;
  return false;
}

struct Way {
  vec3 origin, direction;
  vec3 slope;  // one over the direction
};

Way way_of(vec3 origin, vec3 direction) {
  // No component is zero, so no product below is 0 * infinity.
  vec3 tiny = vec3(1e-20);
  return Way(origin, direction, 1.0 / mix(direction, tiny, lessThan(abs(direction), tiny)));
}

bool enters(Way way, BvhNode node) {
  // A hit may lie outside its triangle's box by 1/4096 of the box's farthest coordinate, seen from the origin
  // (segment_meets_triangle): the box is widened by a little more, rounding included.
  vec3 lo = node.lo - way.origin, hi = node.hi - way.origin;
  vec3 reach = max(abs(lo), abs(hi));
  float margin = max(reach.x, max(reach.y, reach.z)) * (1.0 / 4095.0);
  vec3 t0 = (lo - margin) * way.slope;
  vec3 t1 = (hi + margin) * way.slope;
  vec3 near = min(t0, t1), far = max(t0, t1);
  float enter = max(max(near.x, near.y), max(near.z, 0.0));
  float leave = min(min(far.x, far.y), min(far.z, 1.0));
  return enter <= leave * 1.000001;
}

// Of the nodes from `first` to `end` - 1, a subtree.
bool meets_part(Hierarchy h, uint first, uint end, vec3 origin, vec3 direction) {
  Way way = way_of(origin, direction);
  uint n = first;
  while (n < end) {
    BvhNode node = node_at(h.nodes, n);
    bool met = enters(way, node);
    if (met && node.leaf != 0u && leaf_blocks(h, node.leaf, origin, direction)) return true;
    n = met ? n + 1u : node.skip;
  }
  return false;
}

bool meets(Hierarchy h, vec3 origin, vec3 direction) { return meets_part(h, 0u, h.node_count, origin, direction); }
