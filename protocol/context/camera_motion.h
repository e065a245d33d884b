// Where what a camera sees was in the picture of another one.
#pragma once

#include <array>
#include <optional>

#include "common/tile_mask.h"
#include "protocol/context/slice_model.h"
#include "protocol/types.h"

namespace gnomon::protocol::context {

class CameraMotion {
 public:
  // Both pictures of the grid's size.
  CameraMotion(const CameraView& now, const CameraView& before, const TileGrid& grid);

  // A surface at pixel (x, y), so far from the camera's plane that `nearness` is the inverse of its distance (0: endlessly
  // far), was at (x, y) and this. None: it was behind the other camera.
  std::optional<Motion> at(float x, float y, float nearness) const;
  // About by how much nearness must grow for a place there to move by so many pixels; huge where it does not move.
  float nearness_step(float x, float y, float pixels) const;

 private:
  struct Place {
    float x, y, z;
  };
  Place place(float x, float y, float nearness) const;

  std::array<Vec3, 3>
      right_down_out_;  // of one pixel, one pixel and the first pixel's ray, in the other camera's space
  Vec3 step_;           // of a surface that is near: so far stands the one camera from the other
  float origin_x_, origin_y_, scale_x_, scale_y_;  // pixel = origin + scale * tangent
};

}  // namespace gnomon::protocol::context
