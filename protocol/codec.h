// Encodes visibility masks as slices and decodes them. Lossless in every bit that matters (common/packed_mask.h). A
// slice decodes without the other slices of its frame.
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

inline constexpr size_t kMaxSlices = 65'535;  // of a frame: what a slice's header can number

// A frame cut into slices. The payload of slice i is bytes[offsets[i] .. offsets[i + 1]).
struct EncodedMask {
  CodecId codec = CodecId::tiles_lz4;
  std::vector<SliceHeader> slices;  // the sender fills in frame, times, moment and size
  std::vector<uint8_t> bytes;
  std::vector<size_t> offsets;

  std::span<const uint8_t> payload(size_t slice) const {
    return std::span(bytes).subspan(offsets[slice], offsets[slice + 1] - offsets[slice]);
  }

  void begin(CodecId of);        // without slices; keeps its memory
  Result<void> number_slices();  // error, and then without slices, if there are more than kMaxSlices
};

inline constexpr size_t kMinPayloadBytes = 600;

// One per thread: it reuses its working memory from frame to frame.
class FrameEncoder {
 public:
  FrameEncoder();
  ~FrameEncoder();
  FrameEncoder(FrameEncoder&&) noexcept;

  // No payload is longer than `max_payload_bytes` (at least kMinPayloadBytes). `out`'s memory is reused.
  // Error, with `out` empty, if the frame would take more than kMaxSlices.
  // A frame without lights has no slices.
  Result<void> encode(const TileMaskView& frame, CodecId codec, size_t max_payload_bytes, EncodedMask& out);
  // Equals encoding the unpacked frame, in less time; except that with tiles_context a tile without valid bits is coded
  // as dark or lit, whichever the model expects, for fewer bytes. `reference` and `camera` are used by tiles_context only: a frame of the same grid
  // that the decoder has (may be null), and the camera of this frame (nullopt if it is unknown).
  Result<void> encode(const PackedMaskView& frame, CodecId codec, size_t max_payload_bytes, EncodedMask& out,
                      const MaskReference* reference = nullptr, const std::optional<CameraView>& camera = {});

 private:
  struct Workspace;

  std::unique_ptr<Workspace> workspace_;
};

// True if the slice refers to a frame that `references` (may be null) does not hold, or holds with another grid or
// checksum. Such a slice counts as lost.
bool lacks_reference(const SliceHeader& header, std::span<const uint8_t> payload, const TileGrid& grid,
                     const ReferenceShelf* references);

// Writes a slice's tiles into `words` (grid.word_count() of them, laid out as common/tile_mask.h says). The slice is
// untrusted: any bytes give tiles or an error. After an error the slice's own tiles are unspecified; all others are
// never written. Error also if the slice lacks its reference.
Result<void> decode_slice(const SliceHeader& header, std::span<const uint8_t> payload, const TileGrid& grid,
                          std::span<uint64_t> words, const ReferenceShelf* references = nullptr);

}  // namespace gnomon::protocol
