// Masks made by hand whose pixels have numbers in several planes.
#pragma once

#include <cstdint>
#include <vector>

#include "common/tile_mask.h"

namespace gnomon::test {

// Sets the pixel's bits in the `count` planes from `first` on, the highest of `bits` in the first of them.
inline void set_plane_bits(std::vector<uint64_t>& words, const TileGrid& grid, uint32_t first, uint32_t count,
                           uint32_t x, uint32_t y, uint32_t bits) {
  for (uint32_t i = 0; i < count; ++i) {
    if ((bits >> (count - 1 - i) & 1) == 0) continue;
    const size_t tile = size_t{y / 8} * grid.tiles_x() + x / 8;
    words[size_t{first + i} * grid.tile_count() + tile] |= uint64_t{1} << (y % 8 * 8 + x % 8);
  }
}

}  // namespace gnomon::test
