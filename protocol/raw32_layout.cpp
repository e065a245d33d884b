// The dissertation's layout, the baseline that tiles_lz4 is measured against: for each tile in order, for each of
// its 64 pixels in order, one 32-bit word for each 32 lights of the range, bit l % 32 of word l / 32 for light l.
#include <cstring>

#include "protocol/slice_layout.h"
#include "protocol/types.h"

namespace gnomon::protocol {
namespace {

constexpr uint32_t kPixels = kTileSize * kTileSize;
constexpr uint32_t kMaxWords = (kMaxLights + 31) / 32;

uint32_t words_per_pixel(const SliceRange& range) { return (range.light_count + 31) / 32; }

size_t plain_bytes(const SliceRange& range) {
  return size_t{range.tile_count} * kPixels * words_per_pixel(range) * sizeof(uint32_t);
}

}  // namespace

bool pack_raw32(const TileMaskView& frame, const SliceRange& range, std::vector<uint8_t>& plain) {
  if (range.light_count > kMaxLights || plain_bytes(range) > kMaxPlainBytes) return false;
  plain.assign(plain_bytes(range), 0);
  const uint32_t stride = words_per_pixel(range);
  const uint32_t tile_count = frame.grid.tile_count();
  for (uint32_t t = 0; t < range.tile_count; ++t) {
    uint32_t pixels[kPixels * kMaxWords] = {};
    for (uint32_t l = 0; l < range.light_count; ++l) {
      const uint64_t word = frame.words[size_t{range.first_light + l} * tile_count + range.first_tile + t];
      for (uint32_t p = 0; p < kPixels; ++p) {
        pixels[p * stride + l / 32] |= static_cast<uint32_t>((word >> p) & 1) << (l % 32);
      }
    }
    const size_t tile_bytes = size_t{kPixels} * stride * sizeof(uint32_t);
    std::memcpy(plain.data() + t * tile_bytes, pixels, tile_bytes);
  }
  return true;
}

bool unpack_raw32(std::span<const uint8_t> plain, const SliceRange& range, const TileGrid& grid,
                  std::span<uint64_t> words) {
  if (range.light_count > kMaxLights || plain.size() != plain_bytes(range)) return false;
  const uint32_t stride = words_per_pixel(range);
  const uint8_t* next = plain.data();
  for (uint32_t t = 0; t < range.tile_count; ++t) {
    uint32_t pixels[kPixels * kMaxWords];
    const size_t tile_bytes = size_t{kPixels} * stride * sizeof(uint32_t);
    std::memcpy(pixels, next, tile_bytes);
    next += tile_bytes;
    for (uint32_t l = 0; l < range.light_count; ++l) {
      uint64_t word = 0;
      for (uint32_t p = 0; p < kPixels; ++p) {
        word |= uint64_t{(pixels[p * stride + l / 32] >> (l % 32)) & 1} << p;
      }
      words[size_t{range.first_light + l} * grid.tile_count() + range.first_tile + t] = word;
    }
  }
  return true;
}

}  // namespace gnomon::protocol
