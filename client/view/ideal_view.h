// What a picture would be with a tracer in the client: traced and shaded by this machine alone, with the tracer and the
// shading that the server and the thin client use. For comparison; a thin client has no need of it.
#pragma once

#include <memory>
#include <string>

#include "client/view/own_view.h"
#include "gpu/vulkan_renderer.h"

namespace gnomon::client {

// One thread. Calls block.
class IdealView {
 public:
  // `device`: as gpu::RendererOptions::device. `cache`: folder for light buffers; empty: none are kept.
  static Result<std::unique_ptr<IdealView>> create(const scenes::ScenePtr& scene, const ViewSize& size,
                                                   const std::string& device, const std::string& cache = {});

  // `camera` is of the traced buffer, from which the picture is cut, as a client does with masks of the camera itself.
  // Lights are where the scene has them at `time`. The exposure is chosen at the first picture and stays.
  Result<Picture> picture(const protocol::CameraView& camera, scenes::SceneTime time = {});

 private:
  explicit IdealView(OwnView view, const ViewSize& size) : view_(std::move(view)), size_(size) {}
  Result<AssembledFrame> masks(const protocol::CameraView& camera, scenes::SceneTime time);

  OwnView view_;
  ViewSize size_;
  std::unique_ptr<gpu::Renderer> renderer_;
  uint32_t pictures_ = 0;
};

}  // namespace gnomon::client
