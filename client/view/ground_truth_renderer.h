// The picture that a tracer in the client would give: traced and shaded on this machine alone, with the tracer of the
// server and the shading of the thin client. For comparison; a thin client does not need it.
#pragma once

#include <memory>
#include <string>

#include "client/view/client_renderer.h"
#include "gpu/vulkan_renderer.h"

namespace gnomon::client {

// One thread. Calls block.
class GroundTruthRenderer {
 public:
  // `options`: as ClientRenderer's. `cache`: folder for light buffers; if empty, none are kept.
  static Result<std::unique_ptr<GroundTruthRenderer>> create(const scenes::ScenePtr& scene, const ViewSize& size,
                                                             const ClientRenderer::Options& options,
                                                             const std::string& cache = {});

  // `camera` is of the traced buffer, from which the picture is cut, as a client does with masks of the camera itself.
  // Lights are where the scene has them at `time`. The exposure is chosen for the first picture and kept.
  Result<Picture> picture(const protocol::CameraView& camera, scenes::SceneTime time = {});

 private:
  explicit GroundTruthRenderer(ClientRenderer view, const ViewSize& size) : view_(std::move(view)), size_(size) {}
  Result<AssembledFrame> masks(const protocol::CameraView& camera, scenes::SceneTime time);

  ClientRenderer view_;
  ViewSize size_;
  std::unique_ptr<gpu::Renderer> renderer_;
  uint32_t pictures_ = 0;
};

}  // namespace gnomon::client
