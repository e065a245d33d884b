// Access units of a video as slices, so that they travel over a session's link as masks do, and back in their order.
//
// A slice's first_tile is its unit's number, counted from 1 without gaps; tile_count - 1 is where its bytes begin in
// the unit; light_count is 2 for a key unit, else 1. (A slice has at least one tile and one light.)
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "protocol/codec.h"

namespace gnomon::remote {

struct Unit {
  FrameId frame;  // whose camera it shows
  uint32_t number = 0;
  bool key = false;  // decodes without those before
  std::vector<uint8_t> bytes;
};

protocol::EncodedMask to_slices(const Unit& unit, size_t max_payload_bytes);

// One thread. Memory is bounded by kPatience units.
class UnitAssembler {
 public:
  static constexpr uint32_t kPatience = 4;  // newer units than the one that is waited for

  void add(const protocol::FrameSlice& slice);
  // The next unit in order; or the first key unit after a gap that will not be filled.
  std::optional<Unit> take();
  // A unit was given up, and no key unit has come since.
  bool broken() const { return broken_; }

 private:
  struct Partial {
    Unit unit;
    std::map<uint32_t, std::vector<uint8_t>> parts;  // by where they begin
    size_t slice_count = 0;
    bool whole() const { return parts.size() == slice_count; }
  };

  std::map<uint32_t, Partial> units_;  // by number
  uint32_t next_ = 1;
  bool broken_ = false;
};

}  // namespace gnomon::remote
