// Visibility masks to slices and back. Lossless. Every slice decodes alone.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/packed_mask.h"
#include "common/result.h"
#include "common/tile_mask.h"
#include "protocol/datagram.h"
#include "protocol/mask_reference.h"

namespace gnomon::protocol {

// A frame cut into slices. The payload of slice i is bytes[offsets[i] .. offsets[i + 1]).
struct EncodedFrame {
  CodecId codec = CodecId::tiles_lz4;
  std::vector<SliceHeader> slices;  // frame, server_us and gpu_us are left for the sender to fill in
  std::vector<uint8_t> bytes;
  std::vector<size_t> offsets;

  std::span<const uint8_t> payload(size_t slice) const {
    return std::span(bytes).subspan(offsets[slice], offsets[slice + 1] - offsets[slice]);
  }
};

inline constexpr size_t kMinPayloadBytes = 600;

// One per thread: keeps its working memory from frame to frame.
class FrameEncoder {
 public:
  FrameEncoder();
  ~FrameEncoder();
  FrameEncoder(FrameEncoder&&) noexcept;

  // No payload is longer than `max_payload_bytes` (at least kMinPayloadBytes). `out`'s memory is reused.
  // An error, and `out` empty, when the frame would take more than the 65,535 slices that a header can number.
  // A frame without lights has no slices at all.
  Result<void> encode(const TileMaskView& frame, CodecId codec, size_t max_payload_bytes, EncodedFrame& out);
  // The same of the frame unpacked, in less time; of tiles_context in fewer bytes, as free tiles become what is likely.
  // `reference`, of the same grid, is for tiles_context alone: a frame that the decoder has. `camera`: this frame's.
  Result<void> encode(const PackedMaskView& frame, CodecId codec, size_t max_payload_bytes, EncodedFrame& out,
                      const MaskReference* reference = nullptr, const std::optional<CameraView>& camera = {});

 private:
  struct Workspace;
  Result<void> cut(CodecId codec, size_t max_payload_bytes, EncodedFrame& out);

  std::unique_ptr<Workspace> workspace_;
};

// A frame of tiles_context that several threads encode: unit by unit, each by one of them, then it is joined. The slices
// are the same however many threads take part, and the same as FrameEncoder's.
class SplitFrame {
 public:
  // Copies what it needs of `frame`. `reference`: of the same grid, or null. `camera`: the frame's, if that is known.
  SplitFrame(const PackedMaskView& frame, size_t max_payload_bytes, MaskReferencePtr reference,
             const std::optional<CameraView>& camera = {});
  ~SplitFrame();

  size_t unit_count() const;
  // Any thread; each unit once.
  void encode(size_t unit);
  // After all units. As FrameEncoder::encode.
  Result<void> join(EncodedFrame& out);
  // After all units: the mask that a decoder will have.
  TileMaskView decoded() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

// A slice that refers to a frame which is not among `references`, or not the same there: as good as lost.
bool lacks_reference(const SliceHeader& header, std::span<const uint8_t> payload, const TileGrid& grid,
                     const ReferenceShelf* references);

// Writes a slice's tiles into `words` (grid.word_count() of them, laid out as common/tile_mask.h says).
// Any bytes give tiles or an error; after an error the slice's own tiles are unspecified and all others untouched.
// A slice that lacks its reference is an error.
Result<void> decode_slice(const SliceHeader& header, std::span<const uint8_t> payload, const TileGrid& grid,
                          std::span<uint64_t> words, const ReferenceShelf* references = nullptr);

}  // namespace gnomon::protocol
