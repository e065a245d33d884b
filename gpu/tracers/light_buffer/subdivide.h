// Divides a root square of a face into leaves, top down.
#pragma once

#include <cstdint>
#include <vector>

#include "gpu/tracers/light_buffer/bounds.h"
#include "gpu/tracers/light_buffer/light_buffer.h"

namespace gnomon::gpu::light_buffer {

// A face is built in 2^4 x 2^4 pieces, each by one thread.
inline constexpr uint32_t kRootLevel = 4;
inline constexpr uint32_t kRootCount = 1u << (2 * kRootLevel);
inline constexpr uint32_t kRootCells = 1u << (kTopLevel - kRootLevel);  // along a side

// A leaf is divided while what its queries are expected to cost exceeds what dividing it costs in memory.
struct Detail {
  double cost_per_byte = 4e-8;  // mean cost of a query over the scene's surface, see subdivide.cpp
  uint32_t finest_level = kFinestLevel;
};

// A part of a light buffer. Its words and leaves index these arrays. Leaf 0 is empty.
struct Piece {
  std::vector<uint32_t> cells;  // kRootCells squared
  std::vector<uint32_t> blocks;
  std::vector<Leaf> leaves;
  std::vector<ListEntry> entries;
  uint64_t work = 0;  // footprints looked at, square by square: what building it took
};

// `met`: the footprints that may meet root (i, j). `surface`: the area of all triangles of the scene.
Piece build_piece(const Face& face, const Detail& detail, double surface, uint32_t i, uint32_t j,
                  std::vector<const Footprint*> met);

}  // namespace gnomon::gpu::light_buffer
