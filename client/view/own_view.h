// The client's own half of a frame: rasterises its copy of the scene and shades it with the masks it received.
#pragma once

#include <memory>
#include <string>

#include "client/png.h"
#include "client/view/flight.h"
#include "gpu/reference_view.h"
#include "scenes/scene.h"

namespace gnomon::client {

// One thread. Calls block.
class OwnView {
 public:
  // `device`: as gpu::RendererOptions::device; empty: the best one.
  static Result<OwnView> create(const scenes::ScenePtr& scene, const std::string& device);

  // Both are of the traced size. The exposure is chosen at the first frame and stays.
  Result<Picture> shade(const FlownFrame& frame);
  Result<Picture> material(const FlownFrame& frame);

 private:
  Result<Picture> render(const FlownFrame& frame, const gpu::ShadeOptions& options);

  std::unique_ptr<gpu::ReferenceView> view_;
  std::optional<float> exposure_;
};

gpu::CameraView to_gpu(const protocol::CameraView& camera);

}  // namespace gnomon::client
