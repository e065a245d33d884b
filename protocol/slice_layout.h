// How the two codecs lay a slice's tiles out as plain bytes, before LZ4. WIRE.md has the formats byte by byte.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/tile_mask.h"

namespace gnomon::protocol {

// The tiles and lights of one slice.
struct SliceRange {
  uint32_t first_tile = 0;
  uint32_t tile_count = 0;
  uint32_t first_light = 0;
  uint32_t light_count = 0;
};

// What a tile of one light looks like; two bits on the wire.
enum class TileClass : uint8_t { dark = 0, lit = 1, mixed = 2, edge = 3 };

// A slice's plain bytes never exceed this, so that decoding needs a small fixed buffer.
inline constexpr size_t kMaxPlainBytes = 1 << 16;

// One class for every word of a frame, in the same order.
void classify(std::span<const uint64_t> words, std::vector<TileClass>& classes);

// Pack: replace `plain`; false when it would exceed kMaxPlainBytes.
// Unpack: write the range's words, nothing else; false when `plain` is not exactly what the range needs.
bool pack_tiles(const TileMaskView& frame, std::span<const TileClass> classes, const SliceRange& range,
                std::vector<uint8_t>& plain);
bool unpack_tiles(std::span<const uint8_t> plain, const SliceRange& range, const TileGrid& grid,
                  std::span<uint64_t> words);

bool pack_raw32(const TileMaskView& frame, const SliceRange& range, std::vector<uint8_t>& plain);
bool unpack_raw32(std::span<const uint8_t> plain, const SliceRange& range, const TileGrid& grid,
                  std::span<uint64_t> words);

}  // namespace gnomon::protocol
