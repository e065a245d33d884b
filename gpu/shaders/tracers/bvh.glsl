// Walks a bounding volume hierarchy without a stack: nodes are in depth-first order, and a miss follows `skip`
// (gpu/builds/bvh.h). The result is bit-identical to testing every triangle, because a box is met whenever one
// of its triangles is.
#include "hierarchy.glsl"
#include "texels.glsl"
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
// One of the frame's hierarchies.
struct Tree {
  Hierarchy at;
  bool moves;  // a constant: of the moving geometry, and not of the resting one
};

#ifdef BY_TEXELS

layout(set = 2, binding = 0, rgba32ui) uniform readonly uimageBuffer resting_tree;
#ifdef RESTING_ALONE
uvec4 texel_of(Tree tree, uint n) { return imageLoad(resting_tree, int(n)); }
#else
layout(set = 3, binding = 0, rgba32ui) uniform readonly uimageBuffer moving_tree;
uvec4 texel_of(Tree tree, uint n) {
  if (tree.moves) return imageLoad(moving_tree, int(n));
  return imageLoad(resting_tree, int(n));
}
#endif

BvhNode node_at(Tree tree, uint n) {
  uvec4 a = texel_of(tree, 2u * n), b = texel_of(tree, 2u * n + 1u);
  return BvhNode(uintBitsToFloat(a.xyz), a.w, uintBitsToFloat(b.xyz), b.w);
}

BvhTriangle bvh_triangle_at(Tree tree, uint n) {
  uint at = (tree.at.triangles.x - tree.at.nodes.x) / 16u + 3u * n;
  uvec4 a = texel_of(tree, at), b = texel_of(tree, at + 1u), c = texel_of(tree, at + 2u);
  return BvhTriangle(uintBitsToFloat(a.xyz), a.w, uintBitsToFloat(b.xyz), b.w, uintBitsToFloat(c.xyz), 0u);
}

#else

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer BvhNodes { BvhNode at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer BvhTriangles { BvhTriangle at[]; };

BvhNode node_at(Tree tree, uint n) { return BvhNodes(tree.at.nodes).at[n]; }
BvhTriangle bvh_triangle_at(Tree tree, uint n) { return BvhTriangles(tree.at.triangles).at[n]; }

#endif

bool triangle_blocks(BvhTriangle t, uint first_triangle, vec3 origin, vec3 direction) {
  if (!segment_meets_triangle(origin, direction, t.p0, t.p1, t.p2)) return false;
  return t.masked == 0u || blocks_by_alpha(first_triangle + t.triangle, origin, direction, t.p0, t.p1, t.p2);
}

bool leaf_blocks(Tree tree, uint leaf, vec3 origin, vec3 direction) {
  uint first = leaf >> 4, count = leaf & 15u;
  for (uint i = 0u; i < count; ++i)
    if (triangle_blocks(bvh_triangle_at(tree, first + i), tree.at.first_triangle, origin, direction)) return true;
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
bool meets_part(Tree tree, uint first, uint end, vec3 origin, vec3 direction) {
  Way way = way_of(origin, direction);
  uint n = first;
  while (n < end) {
    BvhNode node = node_at(tree, n);
    bool met = enters(way, node);
    if (met && node.leaf != 0u && leaf_blocks(tree, node.leaf, origin, direction)) return true;
    n = met ? n + 1u : node.skip;
  }
  return false;
}

bool meets(Tree tree, vec3 origin, vec3 direction) {
  return meets_part(tree, 0u, tree.at.node_count, origin, direction);
}
