// The layout of tiles_lz4: for each light of the range a plane of classes, four tiles a byte; then for each light the
// bytes of its tiles that are not uniform, in order.
#include <algorithm>
#include <cstring>

#include "protocol/slice_layout.h"

namespace gnomon::protocol {
namespace {

size_t plane_bytes(const SliceRange& range) { return (size_t{range.tile_count} + 3) / 4; }

void pack_classes(std::span<const TileClass> classes, uint8_t* out) {
  size_t i = 0;
  for (; i + 4 <= classes.size(); i += 4) {
    uint32_t four;
    std::memcpy(&four, &classes[i], sizeof four);
    *out++ = static_cast<uint8_t>(four | four >> 6 | four >> 12 | four >> 18);
  }
  if (i == classes.size()) return;
  uint32_t last = 0;
  std::memcpy(&last, &classes[i], classes.size() - i);
  *out = static_cast<uint8_t>(last | last >> 6 | last >> 12 | last >> 18);
}

}  // namespace

void CodedTiles::begin(size_t words) {
  classes.resize(words);
  starts.resize(words + 1);
  if (bytes.empty()) bytes.resize(4096);
  used_ = 0;
}

void CodedTiles::add_uniform(size_t index, uint32_t count, bool lit) {
  std::fill_n(starts.begin() + static_cast<std::ptrdiff_t>(index), count, static_cast<uint32_t>(used_));
  std::fill_n(classes.begin() + static_cast<std::ptrdiff_t>(index), count, lit ? TileClass::lit : TileClass::dark);
}

void CodedTiles::add_mixed(size_t index, uint64_t word) {
  starts[index] = static_cast<uint32_t>(used_);
  if (bytes.size() - used_ < kMaxTileBytes) bytes.resize(2 * bytes.size());
  uint8_t* end = bytes.data() + used_;
  classes[index] = encode_tile(word, end);
  used_ = static_cast<size_t>(end - bytes.data());
}

// Calls code_words(plane, first, end, index) for the words [first, end) of each plane, the first of which is coded as number
// `index` of the band.
template <class CodeWords>
void CodedTiles::code_planes(const TileGrid& grid, TileRows rows, CodeWords code_words) {
  const size_t of_plane = size_t{rows.count} * grid.tiles_x();
  begin(of_plane * grid.planes);
  for (uint32_t plane = 0; plane < grid.planes; ++plane) {
    const size_t first = size_t{plane} * grid.tile_count() + size_t{rows.first} * grid.tiles_x();
    code_words(plane, first, first + of_plane, plane * of_plane);
  }
  starts.back() = static_cast<uint32_t>(used_);
}

void CodedTiles::code(const TileMaskView& frame, const BandPlan& plan, size_t band) {
  code_planes(frame.grid, plan.rows(band), [&](uint32_t, size_t first, size_t end, size_t index) {
    for (const uint64_t word : frame.words.subspan(first, end - first)) {
      const bool uniform = word + 1 <= 1;  // no bit is set, or all are
      uniform ? add_uniform(index, 1, word & 1) : add_mixed(index, word);
      ++index;
    }
  });
}

void CodedTiles::code(const PackedMaskView& frame, const BandPlan& plan, size_t band) {
  const TileRows rows = plan.rows(band);
  code_planes(frame.grid, rows, [&](uint32_t plane, size_t first, size_t end, size_t index) {
    for_words_between(
        frame, first, end, plan.mixed_before(plane, rows.first),
        [&](size_t word, uint32_t count, bool lit) { add_uniform(index + word - first, count, lit); },
        [&](size_t word, uint64_t bits) { add_mixed(index + word - first, bits); });
  });
}

bool pack_tiles(const CodedTiles& coded, const TileGrid& grid, const SliceRange& range,
                std::vector<uint8_t>& plain) {
  size_t size = plane_bytes(range) * range.light_count;
  for (uint32_t l = 0; l < range.light_count; ++l) {
    size += coded.bytes_between(first_word(grid, range, l), range.tile_count);
  }
  if (size > kMaxPlainBytes) return false;
  plain.resize(size);
  uint8_t* planes = plain.data();
  uint8_t* details = planes + plane_bytes(range) * range.light_count;
  for (uint32_t l = 0; l < range.light_count; ++l, planes += plane_bytes(range)) {
    const size_t first = first_word(grid, range, l);
    pack_classes(std::span(coded.classes).subspan(first, range.tile_count), planes);
    const size_t bytes = coded.bytes_between(first, range.tile_count);
    std::memcpy(details, coded.bytes.data() + coded.starts[first], bytes);
    details += bytes;
  }
  return true;
}

bool unpack_tiles(std::span<const uint8_t> plain, const SliceRange& range, const TileGrid& grid,
                  std::span<uint64_t> words) {
  const size_t all_planes = plane_bytes(range) * range.light_count;
  if (all_planes > plain.size()) return false;
  const uint8_t* plane = plain.data();
  std::span<const uint8_t> details = plain.subspan(all_planes);
  for (uint32_t l = 0; l < range.light_count; ++l, plane += plane_bytes(range)) {
    const auto tiles = words.subspan(first_word(grid, range, l), range.tile_count);
    for (size_t t = 0; t < tiles.size(); ++t) {
      const auto tile_class = static_cast<TileClass>(plane[t / 4] >> (t % 4 * 2) & 3);
      if (tile_class <= TileClass::lit) {
        tiles[t] = tile_class == TileClass::lit ? ~uint64_t{0} : 0;
      } else if (!decode_tile(tile_class, details, tiles[t])) {
        return false;
      }
    }
  }
  return details.empty();
}

}  // namespace gnomon::protocol
