// The interface of a codec of complete frames, for measurements.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "tests/bench/path_masks.h"

namespace gnomon::bench {

// The size of an encoded frame.
struct CodedSize {
  size_t bytes = 0;
  size_t slices = 0;  // 0: not cut into datagrams
};

class FrameCodec {
 public:
  virtual ~FrameCodec() = default;

  virtual std::string name() const = 0;
  // Converts the frame to the form that the codec needs; not measured. `spot` remains valid until the next call.
  virtual void prepare(const TileGrid& grid, const PathSpot& spot) = 0;
  // Both measured. `decode` undoes the last `encode`.
  virtual CodedSize encode() = 0;
  virtual bool decode() = 0;
  // The decoded words, laid out as in common/tile_mask.h; not measured.
  virtual std::span<const uint64_t> words() = 0;
};

}  // namespace gnomon::bench
