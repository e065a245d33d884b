// Cuts a mask into the slices that datagrams carry.
#pragma once

#include <gtest/gtest.h>

#include "protocol/codec.h"

namespace gnomon::tests {

inline protocol::EncodedMask sliced(FrameId frame, const TileMaskView& mask, size_t max_payload_bytes) {
  protocol::EncodedMask encoded;
  const auto done = protocol::FrameEncoder().encode(mask, protocol::CodecId::tiles_lz4, max_payload_bytes, encoded);
  EXPECT_TRUE(done) << done.error().message;
  for (auto& slice : encoded.slices) slice.frame = frame;
  return encoded;
}

}  // namespace gnomon::tests
