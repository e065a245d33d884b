// Makes a frame of small slices.
#pragma once

#include "protocol/codec.h"

namespace gnomon::daemon {

// A frame of `count` slices of one tile each.
inline protocol::EncodedMask frame_of(uint32_t frame, uint16_t count, size_t payload = 100) {
  protocol::EncodedMask made;
  made.offsets.push_back(0);
  for (uint16_t i = 0; i < count; ++i) {
    protocol::SliceHeader header;
    header.frame = FrameId{frame};
    header.slice = i;
    header.slice_count = count;
    header.first_tile = i;
    header.tile_count = header.light_count = 1;
    made.slices.push_back(header);
    made.bytes.resize(made.bytes.size() + payload, static_cast<uint8_t>(i + 1));
    made.offsets.push_back(made.bytes.size());
  }
  return made;
}

}  // namespace gnomon::daemon
