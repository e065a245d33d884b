// A bounding volume hierarchy over the triangles of a world mesh, laid out for traversal without a stack.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "scenes/world_mesh.h"

namespace gnomon::gpu {

// Depth-first order: the first child follows its parent; `skip` is where a ray goes on that misses the box.
struct BvhNode {
  glm::vec3 lo{0.0f};
  uint32_t skip = 0;
  glm::vec3 hi{0.0f};
  uint32_t leaf = 0;  // 0: inner; else first triangle << 4 | number of triangles
};
static_assert(sizeof(BvhNode) == 32);

// In the order of the leaves, beside each other in memory.
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

// Binned surface area heuristic; uses up to `threads` threads. The result does not depend on their number.
Bvh build_bvh(const scenes::WorldMesh& mesh, unsigned threads);

}  // namespace gnomon::gpu
