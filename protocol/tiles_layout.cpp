// The layout of tiles_lz4: for each light of the range a plane of classes, four tiles a byte; then for each light the
// bytes of its tiles that are not uniform, in order.
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

void CodedTiles::add_uniform(size_t index, bool lit) {
  starts[index] = static_cast<uint32_t>(used_);
  classes[index] = lit ? TileClass::lit : TileClass::dark;
}

void CodedTiles::add_mixed(size_t index, uint64_t word) {
  starts[index] = static_cast<uint32_t>(used_);
  if (bytes.size() - used_ < kMaxTileBytes) bytes.resize(2 * bytes.size());
  uint8_t* end = bytes.data() + used_;
  classes[index] = encode_tile(word, end);
  used_ = static_cast<size_t>(end - bytes.data());
}

void CodedTiles::code(std::span<const uint64_t> words) {
  begin(words.size());
  for (size_t i = 0; i < words.size(); ++i) {
    const bool uniform = words[i] + 1 <= 1;  // no bit is set, or all are
    uniform ? add_uniform(i, words[i] & 1) : add_mixed(i, words[i]);
  }
  starts[words.size()] = static_cast<uint32_t>(used_);
}

void CodedTiles::code(const PackedMaskView& packed) {
  begin(packed.grid.word_count());
  for_each_word(
      packed, [this](size_t i, bool lit) { add_uniform(i, lit); },
      [this](size_t i, uint64_t word) { add_mixed(i, word); });
  starts[packed.grid.word_count()] = static_cast<uint32_t>(used_);
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
