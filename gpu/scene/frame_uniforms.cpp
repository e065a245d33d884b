#include "gpu/scene/frame_uniforms.h"

#include "common/tile_mask.h"

namespace gnomon::gpu {

void set_view(FrameUniforms& frame, const CameraView& view, uint32_t width, uint32_t height) {
  const glm::mat3 axes = glm::mat3_cast(view.orientation);
  const glm::vec3 right = axes[0], up = axes[1], forward = -axes[2];
  const float across = view.tan_left + view.tan_right;
  const float upright = view.tan_up + view.tan_down;

  // Rows of the projection: x to the right, y down, reversed depth with an infinite far plane (z = near / depth).
  const glm::vec3 x = (2.0f * right - (view.tan_right - view.tan_left) * forward) / across;
  const glm::vec3 y = (-2.0f * up + (view.tan_up - view.tan_down) * forward) / upright;
  frame.camera_to_clip =
      glm::transpose(glm::mat4(glm::vec4(x, 0.0f), glm::vec4(y, 0.0f), glm::vec4(0.0f, 0.0f, 0.0f, view.near_plane),
                               glm::vec4(forward, 0.0f)));
  frame.camera = view.position;
  frame.forward = forward;
  frame.ray_corner = forward - view.tan_left * right + view.tan_up * up;
  frame.ray_dx = right * (across / static_cast<float>(width));
  frame.ray_dy = up * (-upright / static_cast<float>(height));

  const TileGrid grid{width, height, 0};
  frame.width = width;
  frame.height = height;
  frame.tiles_x = grid.tiles_x();
  frame.tile_count = grid.tile_count();
}

}  // namespace gnomon::gpu
