// A view that was rasterised before, as shaders/predict.comp reads it from the host (scalar block layout, resource
// `seen_view`).
#pragma once

#include "gpu/scene/frame_uniforms.h"

namespace gnomon::gpu {

struct SeenView {
  glm::vec3 eye{0.0f};
  uint32_t width = 0;
  glm::vec3 forward{0.0f};
  uint32_t height = 0;
  glm::vec3 ray_corner{0.0f};
  float pixel = 0;  // width of a pixel at depth 1
  glm::vec3 ray_dx{0.0f};
  glm::vec3 ray_dy{0.0f};
  glm::vec3 across{0.0f};  // ray_dx / |ray_dx|^2; `down` likewise of ray_dy
  glm::vec3 down{0.0f};
  // 1 if the new view is from the same eye, with several samples a pixel: one whose surface no pixel shows then takes
  // the bits of a pixel beside it, instead of counting as lit.
  uint32_t same_eye = 0;

  SeenView() = default;
  SeenView(const CameraView& camera, uint32_t w, uint32_t h) {
    FrameUniforms frame;
    set_view(frame, camera, w, h);
    eye = frame.camera;
    width = w;
    forward = frame.forward;
    height = h;
    ray_corner = frame.ray_corner;
    pixel = glm::length(frame.ray_dx);
    ray_dx = frame.ray_dx;
    ray_dy = frame.ray_dy;
    across = ray_dx / glm::dot(ray_dx, ray_dx);
    down = ray_dy / glm::dot(ray_dy, ray_dy);
  }
};
static_assert(sizeof(SeenView) == 100);

}  // namespace gnomon::gpu
