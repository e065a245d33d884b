#include "protocol/slice_cutter.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace gnomon::protocol {
namespace {

constexpr size_t kTooLong = std::numeric_limits<size_t>::max();

// A slice's length is searched for until its payload is filled to kWellFilled of the limit or, if any length fits,
// after kMaxTrials trials. Each trial aims at kAim of the limit.
constexpr double kWellFilled = 0.94;
constexpr double kAim = 0.98;
constexpr int kMaxTrials = 5;
constexpr double kClassWeight = 0.04;  // expected bytes of a tile's class after LZ4

// The number of lights of which one tile always fits, whatever it shows: each light takes a class and kMaxTileBytes; in
// raw32_lz4, 32 lights take one 32-bit word per pixel.
uint32_t lights_that_fit(CodecId codec, size_t plain_bytes) {
  const size_t lights = codec == CodecId::raw32_lz4 ? plain_bytes / 256 * 32 : plain_bytes / (1 + kMaxTileBytes);
  return static_cast<uint32_t>(std::min<size_t>(lights, kMaxLights));
}

// An estimate to which the range's payload size is roughly proportional: LZ4 compresses classes well and the bytes of
// tiles hardly.
double weight_of(const CodedTiles& tiles, const TileGrid& grid, const SliceRange& range) {
  size_t bytes = 0;
  for (uint32_t l = 0; l < range.light_count; ++l) {
    bytes += tiles.bytes_between(first_word(grid, range, l), range.tile_count);
  }
  return static_cast<double>(bytes) + kClassWeight * range.tile_count * range.light_count;
}

}  // namespace

void SliceCutter::cut_tiles(const CodedTiles& tiles, const TileGrid& grid, size_t max_payload_bytes,
                            EncodedMask& out) {
  tiles_ = &tiles;
  frame_ = {grid, {}};
  limit_ = max_payload_bytes;
  cut_frame(out);
}

void SliceCutter::cut_raw32(const TileMaskView& frame, size_t max_payload_bytes, EncodedMask& out) {
  tiles_ = nullptr;
  frame_ = frame;
  limit_ = max_payload_bytes;
  cut_frame(out);
}

void SliceCutter::cut_frame(EncodedMask& out) {
  const uint32_t tiles = frame_.grid.tile_count();
  const uint32_t lights = frame_.grid.planes;
  const uint32_t step = lights_that_fit(tiles_ ? CodecId::tiles_lz4 : CodecId::raw32_lz4, limit_ - 1);
  for (uint32_t light = 0; light < lights; light += step) {
    SliceRange range{.first_light = light, .light_count = std::min(step, lights - light)};
    ratio_ = 1;
    for (range.first_tile = 0; range.first_tile < tiles; range.first_tile += range.tile_count) {
      if (out.slices.size() > kMaxSlices) return;
      range.tile_count = cut(range, tiles - range.first_tile);
      append(range, out);
    }
  }
}

// Returns approximately the most tiles from range.first_tile on, at most `left`, whose payload fits, and leaves that
// payload in `best_`. The answer lies in [fits, too_many); each trial narrows that, at the place that the bytes per weight
// of the trial before let one expect. Once something fits, few trials are worth it.
uint32_t SliceCutter::cut(SliceRange range, uint32_t left) {
  uint32_t fits = 0;
  uint32_t too_many = left + 1;
  for (int trials = 0; fits + 1 < too_many && (fits == 0 || trials < kMaxTrials); ++trials) {
    range.tile_count = guess(range, fits + 1, too_many - 1);
    const size_t size = try_range(range);
    ratio_ = size == kTooLong ? 2 * ratio_ : static_cast<double>(size) / weight(range);
    if (size > limit_) {
      too_many = range.tile_count;
      continue;
    }
    fits = range.tile_count;
    std::swap(trial_, best_);
    if (static_cast<double>(size) >= kWellFilled * static_cast<double>(limit_)) break;
  }
  return fits;
}

// The most tiles, from `least` to `most`, whose payload is expected to take at most kAim of the limit; else `least`.
uint32_t SliceCutter::guess(SliceRange range, uint32_t least, uint32_t most) const {
  while (least < most) {
    range.tile_count = least + (most - least + 1) / 2;
    if (ratio_ * weight(range) <= kAim * static_cast<double>(limit_)) {
      least = range.tile_count;
    } else {
      most = range.tile_count - 1;
    }
  }
  return least;
}

double SliceCutter::weight(const SliceRange& range) const {
  return tiles_ ? weight_of(*tiles_, frame_.grid, range) : range.tile_count;
}

bool SliceCutter::pack(const SliceRange& range) {
  return tiles_ ? pack_tiles(*tiles_, frame_.grid, range, plain_) : pack_raw32(frame_, range, plain_);
}

// Writes the range's payload to `trial_` and returns its size: exact up to twice the limit, beyond that kTooLong.
size_t SliceCutter::try_range(const SliceRange& range) {
  if (!pack(range)) return kTooLong;
  trial_.resize(1 + 2 * limit_);
  const int packed = LZ4_compress_fast_extState(&lz4_, reinterpret_cast<const char*>(plain_.data()),
                                                reinterpret_cast<char*>(trial_.data() + 1),
                                                static_cast<int>(plain_.size()), static_cast<int>(2 * limit_), 1);
  if (packed > 0 && static_cast<size_t>(packed) < plain_.size()) {
    trial_.resize(1 + static_cast<size_t>(packed));
    trial_[0] = static_cast<uint8_t>(PayloadForm::lz4);
  } else if (plain_.size() <= 2 * limit_) {
    trial_.resize(1 + plain_.size());
    trial_[0] = static_cast<uint8_t>(PayloadForm::plain);
    std::memcpy(trial_.data() + 1, plain_.data(), plain_.size());
  } else {
    return kTooLong;
  }
  return trial_.size();
}

void SliceCutter::append(const SliceRange& range, EncodedMask& out) const {
  SliceHeader header;
  header.first_tile = range.first_tile;
  header.tile_count = range.tile_count;
  header.first_light = static_cast<uint16_t>(range.first_light);
  header.light_count = static_cast<uint16_t>(range.light_count);
  header.codec = tiles_ ? CodecId::tiles_lz4 : CodecId::raw32_lz4;
  out.slices.push_back(header);
  out.bytes.insert(out.bytes.end(), best_.begin(), best_.end());
  out.offsets.push_back(out.bytes.size());
}

}  // namespace gnomon::protocol
