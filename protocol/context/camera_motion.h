// Maps pixels of one camera's picture to where another camera sees the same surface, if that stands still.
#pragma once

#include <array>
#include <optional>

#include "common/tile_mask.h"
#include "protocol/context/slice_model.h"
#include "protocol/types.h"

namespace gnomon::protocol::context {

class CameraMotion {
 public:
  // Both pictures have the grid's size.
  CameraMotion(const CameraView& now, const CameraView& before, const TileGrid& grid);

  // The motion of the surface at pixel (x, y) whose distance from the camera's plane is 1 / `nearness` metres (0:
  // infinitely far): the other picture has it at (x, y) plus this. nullopt if it is behind the other camera, or further
  // than kMostMotion away.
  std::optional<Motion> at(float x, float y, float nearness) const;
  // Approximately the growth of nearness by which a surface there moves by `pixels`; very large if it does not move.
  float nearness_step(float x, float y, float pixels) const;

 private:
  struct Place {
    float x, y, z;
  };
  Place place(float x, float y, float nearness) const;

  std::array<Vec3, 3>
      right_down_out_;  // a ray's step per pixel right and down, and the corner's ray; in the other camera's space
  Vec3 step_;           // position of this camera relative to the other, in the other's space
  float origin_x_, origin_y_, scale_x_, scale_y_;  // pixel = origin + scale * tangent
};

}  // namespace gnomon::protocol::context
