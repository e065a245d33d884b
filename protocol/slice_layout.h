// How the codecs tiles_lz4 and raw32_lz4 lay out a slice's tiles as plain bytes, before LZ4. WIRE.md has the formats.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/packed_mask.h"
#include "common/tile_mask.h"
#include "protocol/band_plan.h"
#include "protocol/tile_code.h"

namespace gnomon::protocol {

// The tiles and lights of one slice.
struct SliceRange {
  uint32_t first_tile = 0;
  uint32_t tile_count = 0;
  uint32_t first_light = 0;
  uint32_t light_count = 0;
};

// A slice's plain bytes never exceed this, so that decoding needs a small fixed buffer.
inline constexpr size_t kMaxPlainBytes = 1 << 16;

// All tiles of a band of a frame, coded, in the order of the words that the band would have as a frame of its own; packing
// a slice is then a few copies.
struct CodedTiles {
  std::vector<TileClass> classes;
  std::vector<uint8_t> bytes;
  std::vector<uint32_t> starts;  // word i has bytes[starts[i] .. starts[i + 1])

  // `plan` is of the frame.
  void code(const TileMaskView& frame, const BandPlan& plan, size_t band);
  void code(const PackedMaskView& frame, const BandPlan& plan, size_t band);
  size_t bytes_between(size_t first_word, size_t words) const {
    return starts[first_word + words] - starts[first_word];
  }

 private:
  template <class CodeWords>
  void code_planes(const TileGrid& grid, TileRows rows, CodeWords code_words);
  void begin(size_t words);
  void add_uniform(size_t index, uint32_t count, bool lit);
  void add_mixed(size_t index, uint64_t word);
  size_t used_ = 0;  // of bytes
};

// The pack functions replace `plain`; false if it would exceed kMaxPlainBytes. The unpack functions write words of the
// range and nothing else; false if `plain` is not exactly what the range needs, and those words are then unspecified.
bool pack_tiles(const CodedTiles& coded, const TileGrid& grid, const SliceRange& range,
                std::vector<uint8_t>& plain);
bool unpack_tiles(std::span<const uint8_t> plain, const SliceRange& range, const TileGrid& grid,
                  std::span<uint64_t> words);

bool pack_raw32(const TileMaskView& frame, const SliceRange& range, std::vector<uint8_t>& plain);
bool unpack_raw32(std::span<const uint8_t> plain, const SliceRange& range, const TileGrid& grid,
                  std::span<uint64_t> words);

// Index of the word of the range's first tile of light range.first_light + `light`.
inline size_t first_word(const TileGrid& grid, const SliceRange& range, uint32_t light) {
  return size_t{range.first_light + light} * grid.tile_count() + range.first_tile;
}

}  // namespace gnomon::protocol
