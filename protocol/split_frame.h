// Encodes one frame with tiles_context on several threads: each unit is encoded by one of them, then the slices are
// joined. The slices do not depend on the number of threads and are identical to FrameEncoder's.
#pragma once

#include <optional>
#include <vector>

#include "protocol/codec.h"
#include "protocol/context/context_slices.h"

namespace gnomon::protocol {

class SplitFrame {
 public:
  // Copies what it needs of `frame`. `reference` is of the same grid, or null. `camera` is the frame's; nullopt if it
  // is unknown.
  SplitFrame(const PackedMaskView& frame, size_t max_payload_bytes, MaskReferencePtr reference,
             const std::optional<CameraView>& camera = {});

  size_t unit_count() const { return units_.size(); }
  // Called once for each unit, from any thread.
  void encode(size_t unit);
  // Precondition: every unit is encoded. Error: as FrameEncoder::encode.
  Result<void> join(EncodedMask& out);
  // The mask that a decoder will have, borrowed from this. Precondition: every unit is encoded.
  TileMaskView decoded() const { return {tiles_.grid, tiles_.words}; }

 private:
  size_t limit_;
  MaskReferencePtr reference_;
  context::FrameTiles tiles_;
  std::vector<SliceRange> units_;
  std::vector<EncodedMask> encoded_;  // for each unit
};

}  // namespace gnomon::protocol
