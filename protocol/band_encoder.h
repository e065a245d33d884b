// Encodes a band of a frame with tiles_lz4.
#pragma once

#include "protocol/band_plan.h"
#include "protocol/codec.h"
#include "protocol/slice_cutter.h"

namespace gnomon::protocol {

// One per thread: it reuses its working memory from frame to frame.
class BandEncoder {
 public:
  // Appends the slices of the band. `plan` is of `frame`. Slices stop once there are more than kMaxSlices.
  void encode(const PackedMaskView& frame, const BandPlan& plan, size_t band, size_t max_payload_bytes,
              EncodedMask& out);
  void encode(const TileMaskView& frame, const BandPlan& plan, size_t band, size_t max_payload_bytes,
              EncodedMask& out);

 private:
  void cut(const TileGrid& grid, TileRows rows, size_t max_payload_bytes, EncodedMask& out);

  CodedTiles coded_;
  SliceCutter cutter_;
};

}  // namespace gnomon::protocol
