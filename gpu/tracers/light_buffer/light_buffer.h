// Light buffers after Haines and Greenberg, "The Light Buffer: A Shadow-Testing Accelerator" (1986): for each light,
// the triangles that can block a segment that leaves the light in a given direction. They are built once for a scene,
// exact for hard shadows, and shared by every view.
//
// A light sees the world through faces: the six of a cube around a point light, one orthographic face for a
// directional one. A face is a grid of 2^kTopLevel squared cells, a cell a block of 2^k x 2^k words, 0 <= k <=
// kBlockBits, chosen by need; a word names a leaf, and neighbouring words may name the same one. So a query reads
// two words and then its leaf, however fine the leaf is. A leaf has
//   a near plane   a point on the light's side of it is lit: nothing that meets the leaf reaches before it;
//   a cover plane  a point behind it is dark: one opaque triangle hides the complete leaf;
//   a list         the triangles in between, near to far, each with its nearest reciprocal depth.
//
// Why the answer equals the shared triangle test (gpu/shaders/exact.glsl) run over every triangle, bit for bit:
//   1. the entries of a list are decided by that test itself;
//   2. a triangle is left out of a leaf only if the test, with all its rounding, must say "no" for every segment
//      that asks the leaf. footprint.h bounds that rounding: a triangle's edges are moved outwards by it, and
//      triangles too thin for the bound (edge-on to the light, slivers, touching the light) are listed wherever
//      the test could be misled, and never bound or cover anything;
//   3. a point in front of the near plane, or behind the cover plane, is so by more than the rounding of the
//      test's plane side and of the comparison itself;
//   4. leaves are padded by more than the rounding of a query's place, computed in floats;
//   5. an entry is passed over only at places outside its box or strip, which hold, widened by that rounding, all of the
//      leaf where 2. lets the test hit the triangle; its depth is rounded towards the light.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace gnomon::gpu::light_buffer {

inline constexpr uint32_t kTopLevel = 8;   // a face has 2^8 x 2^8 cells
inline constexpr uint32_t kBlockBits = 6;  // a cell has at most 2^6 x 2^6 words
inline constexpr uint32_t kFinestLevel = kTopLevel + kBlockBits;
inline constexpr uint32_t kIndexBits = 16;  // a query's place on its face, in fixed point
inline constexpr uint32_t kCellCount = 1u << (2 * kTopLevel);
inline constexpr uint32_t kCountBits = 24;
inline constexpr uint32_t kDepthBits = 3;  // of a cell's word: k; the others: where its block starts

// A leaf, as the shader reads it. `rel` is a surface point relative to the light's reference point, in world axes.
struct Leaf {
  glm::vec3 near_plane{0.0f};   // dot(near_plane, rel) < 1: lit
  uint32_t first = 0;           // of the list, in LightBuffer::entries
  glm::vec3 cover_plane{0.0f};  // dot(cover_plane, rel) > 1: dark
  uint32_t count = 0;           // of the list; in the upper bits from kCountBits on, the leaf's level
};
static_assert(sizeof(Leaf) == 32);

// An entry of a leaf's list, see entry.h. From the upper bits down:
//   depth_and_low    22 bits: a float r >= 0 without its sign, rounded up; if depth * r < 1, the point lies in front of
//                    this triangle and of all that follow (the bits below only make r larger, if they are left in);
//                    y0, x0, 5 bits each: the low corner of the box, the part of the leaf that the triangle can block
//   high_and_strip   high, low, 8 bits each and signed; direction, 6 bits; y1, x1: the high corner of the box, included
// Boxes are in 32nds of the leaf's side. With across_x = 32 - direction, across_y = 32 - |across_x| and a place (x, y) in
// 256ths of that side, the triangle blocks only where low <= (across_x * x + across_y * y) >> 6 <= high.
struct ListEntry {
  uint32_t depth_and_low = 0;
  uint32_t high_and_strip = 0;
  uint32_t triangle = 0;  // index into the world mesh

  bool operator==(const ListEntry&) const = default;
};
static_assert(sizeof(ListEntry) == 12);

// The data of a light that a query needs beside its TracedLight. Point and spot: `reference` is the light's position,
// and depth is the largest component of rel. Directional: `reference` is a point far towards the light, and the axes
// span the face.
struct LightView {
  glm::vec3 reference{0.0f};
  uint32_t directional = 0;
  glm::vec3 u_axis{0.0f};  // directional: (dot(u_axis, rel) + u_offset) is fixed point on the face
  float u_offset = 0;
  glm::vec3 v_axis{0.0f};
  float v_offset = 0;
  glm::vec3 depth_axis{0.0f};
  uint32_t cells = 0;         // index of the first cell in LightBuffer::grid; face by face, row by row
  glm::vec3 direction{0.0f};  // directional: of every segment, as exact::shadow_segment has it
  uint32_t reserved = 0;
};

static_assert(sizeof(LightView) == 80);

struct Statistics {
  double build_seconds = 0;
  uint64_t bytes = 0;
  uint64_t work = 0;  // footprints looked at, square by square; zero if it was read from a cache
  uint64_t leaves = 0;
  uint64_t entries = 0;
  uint32_t longest_list = 0;
};

struct LightBuffer {
  std::vector<LightView> lights;
  std::vector<uint32_t> grid;  // cells of all lights, and their blocks
  std::vector<Leaf> leaves;    // the first one is empty
  std::vector<ListEntry> entries;
  Statistics statistics;

  uint64_t memory_bytes() const {
    return lights.size() * sizeof(LightView) + grid.size() * sizeof(uint32_t) + leaves.size() * sizeof(Leaf) +
           entries.size() * sizeof(ListEntry);
  }
};

}  // namespace gnomon::gpu::light_buffer
