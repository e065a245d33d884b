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

struct Detail {
  double longest_walk = 1.0;  // leaves are divided if more triangles are tested on average
  uint32_t usual_level = 8;   // beyond it, each level doubles that limit
  uint32_t finest_level = kFinestLevel;
};

// A part of a light buffer. Its words and leaves index these arrays. Leaf 0 is empty.
struct Piece {
  std::vector<uint32_t> cells;  // kRootCells squared
  std::vector<uint32_t> blocks;
  std::vector<Leaf> leaves;
  std::vector<ListEntry> entries;
};

// `met`: the footprints that may meet root (i, j).
Piece build_piece(const Face& face, const Detail& detail, uint32_t i, uint32_t j,
                  std::vector<const Footprint*> met);

}  // namespace gnomon::gpu::light_buffer
