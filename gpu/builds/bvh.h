// A bounding volume hierarchy over the triangles of a world mesh, laid out for traversal without a stack.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "scenes/world_mesh.h"

namespace gnomon::gpu {

// Nodes are in depth-first order: the first child follows its parent, and `skip` is the node at which a ray continues
// that misses the box (Smits, "Efficiency Issues for Ray Tracing", 1998).
struct BvhNode {
  glm::vec3 lo{0.0f};
  uint32_t skip = 0;
  glm::vec3 hi{0.0f};
  uint32_t leaf = 0;  // 0: inner; else first triangle << 4 | number of triangles
};
static_assert(sizeof(BvhNode) == 32);

// A triangle with its corners. Triangles are in the order of the leaves, so that a leaf's triangles are adjacent.
struct BvhTriangle {
  glm::vec3 p0{0.0f};
  uint32_t triangle = 0;  // index into WorldMesh::triangles
  glm::vec3 p1{0.0f};
  uint32_t masked = 0;  // 1: blocks only where its alpha test passes
  glm::vec3 p2{0.0f};
  uint32_t reserved = 0;
};
static_assert(sizeof(BvhTriangle) == 48);

struct Bvh {
  std::vector<BvhNode> nodes;
  std::vector<BvhTriangle> triangles;
};

// Builds top down by the binned surface area heuristic (Wald, "On fast Construction of SAH-based Bounding Volume
// Hierarchies", 2007), on up to `threads` threads. The result does not depend on their number.
Bvh build_bvh(const scenes::WorldMesh& mesh, unsigned threads);

}  // namespace gnomon::gpu
