// What the tracer does, as pictures: this client asks light buffers of its own, built from its copy of the scene,
// about the very surface points that the server starts from.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "client/media/png.h"
#include "client/thin_client.h"
#include "client/view/debug_colours.h"
#include "gpu/passes/passes.h"
#include "gpu/picture/blocking_frame.h"

namespace gnomon::client {

// One thread. Calls block. Geometry and lights that move are left as they rest.
class DebugView {
 public:
  // Builds light buffers unless `kind` is mask, which may take long. `device`: as OwnView::create.
  static Result<DebugView> create(const scenes::ScenePtr& scene, const ViewSize& size, DebugKind kind,
                                  const std::string& device);

  // One for each light, without the border: of the camera that the masks are of.
  Result<std::vector<Picture>> pictures(const Received& frame);

 private:
  Picture picture(const Received& frame, uint32_t light, const gpu::SurfaceSample* samples) const;
  Colour colour(const gpu::exact::ShadowSegment& segment, uint32_t light) const;

  DebugKind kind_ = DebugKind::mask;
  ViewSize size_;
  std::unique_ptr<gpu::BlockingFrame> frame_;  // rasterises surface points
  std::vector<gpu::exact::TracedLight> lights_;
  scenes::WorldMesh mesh_;
  gpu::light_buffer::LightBuffer buffer_;
};

}  // namespace gnomon::client
