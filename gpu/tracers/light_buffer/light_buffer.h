// Light buffers after Haines and Greenberg (1986): for each light, what can block a segment that leaves the light
// in a given direction. Built once for a scene, exact for hard shadows, shared by every view.
//
// A light sees the world through faces: the six of a cube around a point light, one orthographic face for a
// directional one. A face is a quadtree of square nodes. The node with indices (i, j) of a level covers
// [i, i + 2) x [j, j + 2) of that level's pitch: neighbours overlap by half, so any footprint no larger than the
// pitch lies wholly within the node that its lower corner falls in, and a group of pixels can ask one node. Beyond
// kGroupLevel, finer than groups of pixels are, nodes cover [i, i + 1) x [j, j + 1).
// A node has
//   a near plane   a point on the light's side of it is lit: nothing that meets the node reaches before it;
//   a cover plane  a point behind it is dark: one opaque triangle hides the whole node;
//   a list         in leaves: the triangles in between, near to far, each with its nearest reciprocal depth.
//
// Why the answer equals the shared triangle test (gpu/shaders/exact.glsl) run over every triangle, bit for bit:
//   1. whatever is left of a list is decided by that very test;
//   2. a triangle is left out of a node only if the test, with all its rounding, must say "no" for every segment
//      that asks the node. footprint.h bounds that rounding: a triangle's edges are moved outwards by it, and
//      triangles too thin for the bound (edge-on to the light, slivers, touching the light) are listed wherever
//      the test could be misled, and never bound or cover anything;
//   3. a point in front of the near plane, or behind the cover plane, is so by more than the rounding of the
//      test's plane side and of the comparison itself;
//   4. nodes are padded by more than the rounding of the node's index, computed in floats by the query.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace gnomon::gpu::light_buffer {

inline constexpr uint32_t kRootLevel = 4;     // a face has 2^4 x 2^4 root nodes
inline constexpr uint32_t kGroupLevel = 8;    // nodes of finer levels do not overlap: single points ask them
inline constexpr uint32_t kFinestLevel = 12;  // no node is finer than a face's side / 2^12
inline constexpr uint32_t kIndexBits = 14;    // a query's position within its face, in fixed point
inline constexpr uint32_t kRootCount = 1u << (2 * kRootLevel);
inline constexpr uint32_t kNone = 0xffffffff;

// Cube faces reach a little beyond 90 degrees, so that groups of pixels at their rims need not be split.
inline constexpr float kFaceExtent = 1.0625f;

// As the shader reads it. `rel` is a surface point relative to the light's reference point, in world axes.
struct Node {
  glm::vec3 near_plane;   // dot(near_plane, rel) < 1: lit
  uint32_t children;      // first of four (x fastest) in LightBuffer::nodes; kNone: a leaf
  glm::vec3 cover_plane;  // dot(cover_plane, rel) > 1: dark
  uint32_t list;          // leaf: index in LightBuffer::lists of a count, followed by that many ListEntry
};
static_assert(sizeof(Node) == 32);

// depth * reciprocal_depth < 1: the point lies before this triangle and all that follow.
struct ListEntry {
  uint32_t triangle;  // index into the world mesh
  float reciprocal_depth;
};

// What a query needs to know of a light beside its TracedLight. Point and spot: `reference` is the light's position
// and depth is the largest component of rel. Directional: a point far up the light; the axes span the face.
struct LightView {
  glm::vec3 reference{0.0f};
  uint32_t directional = 0;
  glm::vec3 u_axis{0.0f};  // directional: (dot(u_axis, rel) + u_offset) is fixed point on the face
  float u_offset = 0;
  glm::vec3 v_axis{0.0f};
  float v_offset = 0;
  glm::vec3 depth_axis{0.0f};
  uint32_t roots = 0;         // index of the first root; a face's roots follow one another, then the next face's
  glm::vec3 direction{0.0f};  // directional: of every segment, as exact::shadow_segment has it
  uint32_t reserved = 0;
};

static_assert(sizeof(LightView) == 80);

struct Statistics {
  double build_seconds = 0;
  uint64_t bytes = 0;
  uint64_t leaves = 0;
  uint64_t entries = 0;
  uint32_t longest_list = 0;
};

struct LightBuffer {
  std::vector<LightView> lights;
  std::vector<Node> nodes;
  std::vector<uint32_t> lists;
  Statistics statistics;

  uint64_t memory_bytes() const {
    return lights.size() * sizeof(LightView) + nodes.size() * sizeof(Node) + lists.size() * sizeof(uint32_t);
  }
};

}  // namespace gnomon::gpu::light_buffer
