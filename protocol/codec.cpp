#include "protocol/codec.h"

#include <lz4.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <string>

#include "protocol/band_encoder.h"
#include "protocol/context/context_slices.h"
#include "protocol/slice_cutter.h"

namespace gnomon::protocol {

struct FrameEncoder::Workspace {
  BandPlan bands;               // of tiles_lz4
  BandEncoder band_encoder;     // of tiles_lz4
  std::vector<uint64_t> words;  // of a packed frame, for raw32_lz4
  SliceCutter cutter;           // of raw32_lz4
  context::FrameTiles framed;   // of tiles_context
  context::UnitEncoder units;

  template <class MaskView>
  void cut_bands(const MaskView& frame, size_t limit, EncodedMask& out) {
    bands.plan(frame);
    for (size_t band = 0; band < bands.band_count(); ++band) {
      band_encoder.encode(frame, bands, band, limit, out);
      if (out.slices.size() > kMaxSlices) return;
    }
  }

  void cut_context(size_t limit, EncodedMask& out) {
    for (const SliceRange& unit : context::plan_units(framed, limit)) {
      units.encode(framed, unit, limit, out);
      if (out.slices.size() > kMaxSlices) return;
    }
  }
};

void EncodedMask::begin(CodecId of) {
  codec = of;
  slices.clear();
  bytes.clear();
  offsets.assign(1, 0);
}

Result<void> EncodedMask::number_slices() {
  if (slices.size() > kMaxSlices) {
    begin(codec);
    return Error{"the frame takes more than " + std::to_string(kMaxSlices) + " slices"};
  }
  for (size_t i = 0; i < slices.size(); ++i) {
    slices[i].slice = static_cast<uint16_t>(i);
    slices[i].slice_count = static_cast<uint16_t>(slices.size());
  }
  return {};
}

namespace {

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
  if (payload[0] == static_cast<uint8_t>(PayloadForm::plain)) return rest;
  if (payload[0] != static_cast<uint8_t>(PayloadForm::lz4)) return {};
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
                                  EncodedMask& out) {
  assert(frame.words.size() == frame.grid.word_count() && max_payload_bytes >= kMinPayloadBytes);
  Workspace& work = *workspace_;
  out.begin(codec);
  switch (codec) {
    case CodecId::raw32_lz4: work.cutter.cut_raw32(frame, max_payload_bytes, out); break;
    case CodecId::tiles_lz4: work.cut_bands(frame, max_payload_bytes, out); break;
    case CodecId::tiles_context:
      work.framed.take(frame);
      work.framed.refer_to(nullptr, {});
      work.cut_context(max_payload_bytes, out);
      break;
  }
  return out.number_slices();
}

Result<void> FrameEncoder::encode(const PackedMaskView& frame, CodecId codec, size_t max_payload_bytes,
                                  EncodedMask& out, const MaskReference* reference,
                                  const std::optional<CameraView>& camera) {
  assert(max_payload_bytes >= kMinPayloadBytes);
  Workspace& work = *workspace_;
  out.begin(codec);
  switch (codec) {
    case CodecId::raw32_lz4:
      work.words.resize(frame.grid.word_count());
      unpack(frame, work.words);
      work.cutter.cut_raw32({frame.grid, work.words}, max_payload_bytes, out);
      break;
    case CodecId::tiles_lz4: work.cut_bands(frame, max_payload_bytes, out); break;
    case CodecId::tiles_context:
      work.framed.take(frame);
      work.framed.refer_to(reference, camera);
      work.cut_context(max_payload_bytes, out);
      break;
  }
  return out.number_slices();
}

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
