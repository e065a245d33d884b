// A visibility mask: one bit for each light and pixel, stored as 8x8-pixel tiles of 64 bits.
//
// The word of a tile is words[plane * tile_count + tile_y * tiles_x + tile_x], where each light has a plane; within a word, the bit of pixel (x, y)
// of the tile is number y * 8 + x, counted from the least significant. 1: the light sees the surface. A tracer leaves 0
// in the bits of pixels beyond the right and lower edge of a picture whose size is not a multiple of 8, of pixels that
// show no surface, and of lights that do not shine on the surface (behind it, out of range or cone). After packing,
// these bits may have any value (common/packed_mask.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace gnomon {

inline constexpr uint32_t kTileSize = 8;

struct TileGrid {
  uint32_t width = 0;   // pixels
  uint32_t height = 0;  // pixels
  uint32_t planes = 0;  // one for each light; several for an area light (common/light_planes.h)

  constexpr uint32_t tiles_x() const { return (width + kTileSize - 1) / kTileSize; }
  constexpr uint32_t tiles_y() const { return (height + kTileSize - 1) / kTileSize; }
  constexpr uint32_t tile_count() const { return tiles_x() * tiles_y(); }
  constexpr size_t word_count() const { return size_t{planes} * tile_count(); }
  constexpr uint64_t bits() const { return uint64_t{width} * height * planes; }  // without those beyond the edges
  friend constexpr bool operator==(const TileGrid&, const TileGrid&) = default;
};

// A range of rows of tiles, counted from the top.
struct TileRows {
  uint32_t first = 0;
  uint32_t count = 0;

  constexpr uint32_t end() const { return first + count; }
  friend constexpr bool operator==(const TileRows&, const TileRows&) = default;
};

// Borrowed words of one frame; their owner (a frame lease, a decoder) states how long they are valid.
struct TileMaskView {
  TileGrid grid;
  std::span<const uint64_t> words;  // grid.word_count() of them

  bool lit(uint32_t x, uint32_t y, uint32_t plane) const {
    const size_t tile = size_t{y / kTileSize} * grid.tiles_x() + x / kTileSize;
    const uint64_t word = words[size_t{plane} * grid.tile_count() + tile];
    return (word >> ((y % kTileSize) * kTileSize + x % kTileSize)) & 1;
  }
};

}  // namespace gnomon
