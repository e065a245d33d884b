#include "protocol/codec.h"

#include <lz4.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <limits>
#include <string>

#include "protocol/context/context_slices.h"
#include "protocol/slice_layout.h"

namespace gnomon::protocol {
namespace {

// A payload's first byte.
enum class Form : uint8_t { plain = 0, lz4 = 1 };

constexpr size_t kMaxSlices = std::numeric_limits<uint16_t>::max();
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

}  // namespace

struct FrameEncoder::Workspace {
  TileMaskView frame;
  CodecId codec = CodecId::tiles_lz4;
  size_t limit = 0;  // bytes of a payload
  double ratio = 1;  // payload bytes per unit of weight(), as the last trial measured it
  LZ4_stream_t lz4;
  CodedTiles coded;             // of tiles_lz4
  std::vector<uint64_t> words;  // of a packed frame, for raw32_lz4
  std::vector<uint8_t> plain;
  std::vector<uint8_t> trial;  // the payload tried last
  std::vector<uint8_t> best;   // the longest payload so far that fits
  context::FrameTiles framed;  // of tiles_context
  context::UnitEncoder units;

  bool pack(const SliceRange& range) {
    return codec == CodecId::raw32_lz4 ? pack_raw32(frame, range, plain)
                                       : pack_tiles(coded, frame.grid, range, plain);
  }

  // An estimate to which the range's payload size is roughly proportional: LZ4 compresses classes well and the bytes of
  // tiles hardly.
  double weight(const SliceRange& range) const {
    if (codec == CodecId::raw32_lz4) return range.tile_count;
    size_t bytes = 0;
    for (uint32_t l = 0; l < range.light_count; ++l) {
      bytes += coded.bytes_between(first_word(frame.grid, range, l), range.tile_count);
    }
    return static_cast<double>(bytes) + kClassWeight * range.tile_count * range.light_count;
  }

  // The most tiles, from `least` to `most`, whose payload is expected to take at most kAim of the limit; else `least`.
  uint32_t guess(SliceRange range, uint32_t least, uint32_t most) const {
    while (least < most) {
      range.tile_count = least + (most - least + 1) / 2;
      if (ratio * weight(range) <= kAim * static_cast<double>(limit)) {
        least = range.tile_count;
      } else {
        most = range.tile_count - 1;
      }
    }
    return least;
  }

  // Writes the range's payload to `trial` and returns its size: exact up to twice the limit, beyond that kTooLong.
  size_t try_range(const SliceRange& range) {
    if (!pack(range)) return kTooLong;
    trial.resize(1 + 2 * limit);
    const int packed = LZ4_compress_fast_extState(&lz4, reinterpret_cast<const char*>(plain.data()),
                                                  reinterpret_cast<char*>(trial.data() + 1),
                                                  static_cast<int>(plain.size()), static_cast<int>(2 * limit), 1);
    if (packed > 0 && static_cast<size_t>(packed) < plain.size()) {
      trial.resize(1 + static_cast<size_t>(packed));
      trial[0] = static_cast<uint8_t>(Form::lz4);
    } else if (plain.size() <= 2 * limit) {
      trial.resize(1 + plain.size());
      trial[0] = static_cast<uint8_t>(Form::plain);
      std::memcpy(trial.data() + 1, plain.data(), plain.size());
    } else {
      return kTooLong;
    }
    return trial.size();
  }

  // Returns approximately the most tiles from range.first_tile on, at most `left`, whose payload fits, and leaves that
  // payload in `best`.
  uint32_t cut(SliceRange range, uint32_t left) {
    uint32_t fits = 0;
    uint32_t too_many = left + 1;
    for (int trials = 0; fits + 1 < too_many && (fits == 0 || trials < kMaxTrials); ++trials) {
      range.tile_count = guess(range, fits + 1, too_many - 1);
      const size_t size = try_range(range);
      ratio = size == kTooLong ? 2 * ratio : static_cast<double>(size) / weight(range);
      if (size > limit) {
        too_many = range.tile_count;
        continue;
      }
      fits = range.tile_count;
      std::swap(trial, best);
      if (static_cast<double>(size) >= kWellFilled * static_cast<double>(limit)) break;
    }
    return fits;
  }

  bool cut_context(EncodedFrame& out) {
    for (const SliceRange& unit : context::plan_units(framed, limit)) {
      units.encode(framed, unit, limit, out);
      if (out.slices.size() > kMaxSlices) return false;
    }
    return true;
  }

  bool cut_frame(EncodedFrame& out) {
    if (codec == CodecId::tiles_context) return cut_context(out);
    const uint32_t tiles = frame.grid.tile_count();
    const uint32_t lights = frame.grid.planes;
    const uint32_t step = lights_that_fit(codec, limit - 1);
    for (uint32_t light = 0; light < lights; light += step) {
      SliceRange range{.first_light = light, .light_count = std::min(step, lights - light)};
      ratio = 1;
      for (range.first_tile = 0; range.first_tile < tiles; range.first_tile += range.tile_count) {
        if (out.slices.size() == kMaxSlices) return false;
        range.tile_count = cut(range, tiles - range.first_tile);
        append(range, out);
      }
    }
    return true;
  }

  void append(const SliceRange& range, EncodedFrame& out) const {
    SliceHeader header;
    header.first_tile = range.first_tile;
    header.tile_count = range.tile_count;
    header.first_light = static_cast<uint16_t>(range.first_light);
    header.light_count = static_cast<uint16_t>(range.light_count);
    header.codec = codec;
    out.slices.push_back(header);
    out.bytes.insert(out.bytes.end(), best.begin(), best.end());
    out.offsets.push_back(out.bytes.size());
  }
};

namespace {

void clear(EncodedFrame& frame) {
  frame.slices.clear();
  frame.bytes.clear();
  frame.offsets.assign(1, 0);
}

void number_slices(EncodedFrame& frame) {
  for (size_t i = 0; i < frame.slices.size(); ++i) {
    frame.slices[i].slice = static_cast<uint16_t>(i);
    frame.slices[i].slice_count = static_cast<uint16_t>(frame.slices.size());
  }
}

Error too_many_slices() { return Error{"the frame takes more than " + std::to_string(kMaxSlices) + " slices"}; }

bool is_inside(const SliceRange& range, const TileGrid& grid) {
  return range.tile_count > 0 && range.first_tile < grid.tile_count() &&
         range.tile_count <= grid.tile_count() - range.first_tile && range.light_count > 0 &&
         range.first_light + range.light_count <= grid.planes;
}

using PlainBuffer = std::array<uint8_t, kMaxPlainBytes>;

// The payload's plain bytes, which lie in the payload itself or in `buffer`; empty if the payload is malformed.
std::span<const uint8_t> plain_bytes(std::span<const uint8_t> payload, PlainBuffer& buffer) {
  if (payload.empty() || payload.size() > 1 + buffer.size()) return {};
  const auto rest = payload.subspan(1);
  if (payload[0] == static_cast<uint8_t>(Form::plain)) return rest;
  if (payload[0] != static_cast<uint8_t>(Form::lz4)) return {};
  const int size =
      LZ4_decompress_safe(reinterpret_cast<const char*>(rest.data()), reinterpret_cast<char*>(buffer.data()),
                          static_cast<int>(rest.size()), static_cast<int>(buffer.size()));
  return std::span(buffer).first(static_cast<size_t>(std::max(size, 0)));
}

}  // namespace

FrameEncoder::FrameEncoder() : workspace_(std::make_unique<Workspace>()) {}
FrameEncoder::~FrameEncoder() = default;
FrameEncoder::FrameEncoder(FrameEncoder&&) noexcept = default;

Result<void> FrameEncoder::encode(const TileMaskView& frame, CodecId codec, size_t max_payload_bytes,
                                  EncodedFrame& out) {
  assert(frame.words.size() == frame.grid.word_count());
  workspace_->frame = frame;
  if (codec == CodecId::tiles_lz4) workspace_->coded.code(frame.words);
  if (codec == CodecId::tiles_context) workspace_->framed.take(frame);
  workspace_->framed.refer_to(nullptr, {});
  return cut(codec, max_payload_bytes, out);
}

Result<void> FrameEncoder::encode(const PackedMaskView& frame, CodecId codec, size_t max_payload_bytes,
                                  EncodedFrame& out, const MaskReference* reference,
                                  const std::optional<CameraView>& camera) {
  Workspace& work = *workspace_;
  work.frame = {frame.grid, {}};
  if (codec == CodecId::tiles_lz4) {
    work.coded.code(frame);
  } else if (codec == CodecId::tiles_context) {
    work.framed.take(frame);
    work.framed.refer_to(reference, camera);
  } else {
    work.words.resize(frame.grid.word_count());
    unpack(frame, work.words);
    work.frame.words = work.words;
  }
  return cut(codec, max_payload_bytes, out);
}

// Cuts the frame that encode() has put into the workspace.
Result<void> FrameEncoder::cut(CodecId codec, size_t max_payload_bytes, EncodedFrame& out) {
  assert(max_payload_bytes >= kMinPayloadBytes);
  clear(out);
  out.codec = codec;
  Workspace& work = *workspace_;
  work.codec = codec;
  work.limit = max_payload_bytes;
  const bool all_cut = work.cut_frame(out);
  work.frame = {};
  if (!all_cut) {
    clear(out);
    return too_many_slices();
  }
  number_slices(out);
  return {};
}

struct SplitFrame::Parts {
  context::FrameTiles tiles;
  size_t limit = 0;
  MaskReferencePtr reference;
  std::vector<SliceRange> units;
  std::vector<EncodedFrame> encoded;  // for each unit
};

SplitFrame::SplitFrame(const PackedMaskView& frame, size_t max_payload_bytes, MaskReferencePtr reference,
                       const std::optional<CameraView>& camera)
    : parts_(std::make_unique<Parts>()) {
  assert(max_payload_bytes >= kMinPayloadBytes);
  parts_->limit = max_payload_bytes;
  parts_->tiles.take(frame);
  parts_->tiles.refer_to(reference.get(), camera);
  parts_->reference = std::move(reference);
  parts_->units = context::plan_units(parts_->tiles, max_payload_bytes);
  parts_->encoded.resize(parts_->units.size());
}

SplitFrame::~SplitFrame() = default;

size_t SplitFrame::unit_count() const { return parts_->units.size(); }

void SplitFrame::encode(size_t unit) {
  static thread_local context::UnitEncoder encoder;
  clear(parts_->encoded[unit]);
  encoder.encode(parts_->tiles, parts_->units[unit], parts_->limit, parts_->encoded[unit]);
}

Result<void> SplitFrame::join(EncodedFrame& out) {
  clear(out);
  out.codec = CodecId::tiles_context;
  for (const EncodedFrame& part : parts_->encoded) {
    if (out.slices.size() + part.slices.size() > kMaxSlices) {
      clear(out);
      return too_many_slices();
    }
    const size_t first = out.bytes.size();
    out.slices.insert(out.slices.end(), part.slices.begin(), part.slices.end());
    out.bytes.insert(out.bytes.end(), part.bytes.begin(), part.bytes.end());
    for (size_t i = 1; i < part.offsets.size(); ++i) out.offsets.push_back(first + part.offsets[i]);
  }
  number_slices(out);
  return {};
}

TileMaskView SplitFrame::decoded() const { return {parts_->tiles.grid, parts_->tiles.words}; }

bool lacks_reference(const SliceHeader& header, std::span<const uint8_t> payload, const TileGrid& grid,
                     const ReferenceShelf* references) {
  return header.codec == CodecId::tiles_context && context::lacks_reference(payload, grid, references);
}

Result<void> decode_slice(const SliceHeader& header, std::span<const uint8_t> payload, const TileGrid& grid,
                          std::span<uint64_t> words, const ReferenceShelf* references) {
  assert(words.size() == grid.word_count());
  const SliceRange range{header.first_tile, header.tile_count, header.first_light, header.light_count};
  if (!is_inside(range, grid)) return Error{"a slice's tiles or lights are not of this frame"};
  if (header.codec == CodecId::tiles_context) return context::decode(range, payload, grid, references, words);
  PlainBuffer buffer;  // not initialised: only unpacked bytes are read
  const auto plain = plain_bytes(payload, buffer);
  if (plain.empty()) return Error{"a slice's payload is of unknown form or damaged"};
  bool exact = false;
  switch (header.codec) {
    case CodecId::raw32_lz4: exact = unpack_raw32(plain, range, grid, words); break;
    case CodecId::tiles_lz4: exact = unpack_tiles(plain, range, grid, words); break;
    default: return Error{"a slice of unknown codec"};
  }
  if (!exact) return Error{"a slice's size does not match its tiles"};
  return {};
}

}  // namespace gnomon::protocol
