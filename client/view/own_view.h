// The client's own half of a frame: rasterises its copy of the scene, as it is at the frame's moment, and shades it with
// the masks and lights it received.
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

  // All are of the traced size. The exposure is chosen at the first frame and stays.
  Result<Picture> shade(const FlownFrame& frame);
  // What each light sees: base colours, black elsewhere.
  Result<std::vector<Picture>> seen_by_lights(const FlownFrame& frame);

 private:
  Result<Picture> render(const FlownFrame& frame, gpu::ShadeOptions options);

  Result<void> take_lights(const FlownFrame& frame);

  std::unique_ptr<gpu::ReferenceView> view_;
  std::vector<protocol::LightInfo> lights_;  // that the view has; empty: the scene's own
  std::optional<float> exposure_;
};

gpu::CameraView to_gpu(const protocol::CameraView& camera);
scenes::Light to_scene(const protocol::LightInfo& light);  // without a name

}  // namespace gnomon::client
