// The shape of the masks that a server sends: their size, and the planes of each light. It is what Welcome grants until
// Degraded or SceneChanged say something else. Slices say themselves of which size and samples they are, where the session
// has the features for that, so that those of another shape are never taken for what they are not. One thread.
#pragma once

#include <vector>

#include "common/light_planes.h"
#include "common/tile_mask.h"
#include "protocol/datagram.h"
#include "protocol/messages.h"

namespace gnomon::client {

class MaskShape {
 public:
  MaskShape() = default;
  explicit MaskShape(const protocol::Welcome& granted);

  void take(const protocol::Degraded& degraded);
  void take(const protocol::SceneChanged& changed);
  void take(const protocol::LightsChanged& changed);

  TileGrid grid() const { return {width_, height_, planes().total()}; }
  LightPlanes planes() const { return LightPlanes(is_area_, samples_); }

  // Whether the slice is of this shape, as far as it says so.
  bool is_of(const protocol::SliceHeader& header) const;
  // Whether slices of that shape and of this one can be told apart by what they say. They never say how many lights there
  // are, nor which of them have an extent.
  bool tells_apart(const MaskShape& other) const;

 private:
  bool has(uint64_t feature) const { return (features_ & feature) != 0; }

  uint64_t features_ = 0;
  uint32_t granted_width_ = 0, granted_height_ = 0;
  uint32_t width_ = 0, height_ = 0;
  SampleCounts granted_samples_, samples_;
  std::vector<bool> is_area_;  // of the lights
};

}  // namespace gnomon::client
