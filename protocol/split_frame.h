// Encodes one frame with tiles_context or tiles_lz4 on several threads: each unit is encoded by one of them, then the slices
// are joined. The slices do not depend on the number of threads and are identical to FrameEncoder's.
#pragma once

#include <optional>
#include <vector>

#include "protocol/band_plan.h"
#include "protocol/codec.h"
#include "protocol/context/context_slices.h"

namespace gnomon::protocol {

class SplitFrame {
 public:
  // Of tiles_context: copies what it needs of `frame`. `reference` is of the same grid, or null. `camera` is the frame's;
  // nullopt if it is unknown.
  static SplitFrame of_context(const PackedMaskView& frame, size_t max_payload_bytes, MaskReferencePtr reference,
                               const std::optional<CameraView>& camera = {});
  // Of tiles_lz4: `frame` must stay valid until every unit is encoded.
  static SplitFrame of_bands(const PackedMaskView& frame, size_t max_payload_bytes);

  size_t unit_count() const { return encoded_.size(); }
  // Called once for each unit, from any thread.
  void encode(size_t unit);
  // Precondition: every unit is encoded. Error: as FrameEncoder::encode.
  Result<void> join(EncodedMask& out);
  // Of tiles_context: the mask that a decoder will have, borrowed from this. Precondition: every unit is encoded.
  TileMaskView decoded() const { return {tiles_.grid, tiles_.words}; }

 private:
  SplitFrame(CodecId codec, size_t max_payload_bytes) : codec_(codec), limit_(max_payload_bytes) {}

  CodecId codec_;
  size_t limit_;
  std::vector<EncodedMask> encoded_;  // for each unit

  MaskReferencePtr reference_;  // this and the next two of tiles_context
  context::FrameTiles tiles_;
  std::vector<SliceRange> units_;

  PackedMaskView mask_;  // this and the next of tiles_lz4
  BandPlan bands_;
};

}  // namespace gnomon::protocol
