// Something that codes whole frames of masks, seen from the stopwatch.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "tests/bench/path_masks.h"

namespace gnomon::bench {

// What a frame became.
struct CodedSize {
  size_t bytes = 0;
  size_t slices = 0;  // 0: not cut into datagrams
};

class FrameCodec {
 public:
  virtual ~FrameCodec() = default;

  virtual std::string name() const = 0;
  // Takes over what it codes, in whatever form it likes best; not measured. The spot lives until the next call.
  virtual void prepare(const TileGrid& grid, const PathSpot& spot) = 0;
  // Both measured. `decode` undoes the last `encode`.
  virtual CodedSize encode() = 0;
  virtual bool decode() = 0;
  // What was decoded, as common/tile_mask.h; not measured.
  virtual std::span<const uint64_t> words() = 0;
};

}  // namespace gnomon::bench
