// Cuts frames of the codecs tiles_lz4 and raw32_lz4 into slices that fill their datagrams.
#pragma once

#include <lz4.h>

#include <cstdint>
#include <vector>

#include "protocol/codec.h"
#include "protocol/slice_layout.h"

namespace gnomon::protocol {

// A payload's first byte, of both codecs.
enum class PayloadForm : uint8_t { plain = 0, lz4 = 1 };

// One per thread: it reuses its working memory from frame to frame.
class SliceCutter {
 public:
  // Append the frame's slices to `out`; no payload is longer than `max_payload_bytes`. They stop once there are more
  // than kMaxSlices.
  void cut_tiles(const CodedTiles& tiles, const TileGrid& grid, size_t max_payload_bytes, EncodedMask& out);
  void cut_raw32(const TileMaskView& frame, size_t max_payload_bytes, EncodedMask& out);

 private:
  void cut_frame(EncodedMask& out);
  uint32_t cut(SliceRange range, uint32_t left);
  size_t try_range(const SliceRange& range);
  uint32_t guess(SliceRange range, uint32_t least, uint32_t most) const;
  double weight(const SliceRange& range) const;
  bool pack(const SliceRange& range);
  void append(const SliceRange& range, EncodedMask& out) const;

  const CodedTiles* tiles_ = nullptr;  // of tiles_lz4; null: raw32_lz4
  TileMaskView frame_;                 // of raw32_lz4; of tiles_lz4 only its grid
  size_t limit_ = 0;                   // bytes of a payload
  double ratio_ = 1;                   // payload bytes per unit of weight(), as the last trial measured it
  LZ4_stream_t lz4_;
  std::vector<uint8_t> plain_;
  std::vector<uint8_t> trial_;  // the payload tried last
  std::vector<uint8_t> best_;   // the longest payload so far that fits
};

}  // namespace gnomon::protocol
