// Pictures of what the tracer does: this client queries light buffers of its own, built from its copy of the scene, at
// the same surface points that the server starts from.
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

// One thread. Calls block. In the light buffers, geometry and lights that move are at rest.
class DebugView {
 public:
  // Builds light buffers, which may take long, unless `kind` is mask. `device`: as of ClientRenderer::create().
  static Result<DebugView> create(const scenes::ScenePtr& scene, const ViewSize& size, DebugKind kind,
                                  const std::string& device);

  // One picture for each light, without the border, of the camera of the masks.
  Result<std::vector<Picture>> pictures(const ReceivedMasks& frame);

 private:
  Picture picture(const ReceivedMasks& frame, uint32_t light, const gpu::SurfaceSample* samples) const;
  Colour colour(const gpu::exact::ShadowSegment& segment, uint32_t light) const;

  DebugKind kind_ = DebugKind::mask;
  ViewSize size_;
  std::unique_ptr<gpu::BlockingFrame> frame_;  // rasterises surface points
  std::vector<gpu::exact::TracedLight> lights_;
  scenes::WorldMesh mesh_;
  gpu::light_buffer::LightBuffer buffer_;
};

}  // namespace gnomon::client
