// One scene, one slot: renders a frame and waits for it. What the reference view and the surface probe stand on; a
// server uses Renderer.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gpu/frame_slot.h"
#include "gpu/tracers/tracer.h"
#include "gpu/vulkan_renderer.h"

namespace gnomon::gpu {

class BlockingFrame {
 public:
  // `options`' passes are replaced by `passes`; its tracer is made only if one of them traces.
  static Result<std::unique_ptr<BlockingFrame>> create(const RendererOptions& options,
                                                       const std::vector<std::string>& passes,
                                                       const scenes::ScenePtr& scene);

  const Device& device() const { return *device_; }
  const ResidentScene& scene() const { return *scene_; }

  // Makes room, so that host() can be written. Error: size out of range, out of memory.
  Result<TileGrid> reserve(uint32_t width, uint32_t height);
  // Renders what was reserved and waits. Error: device lost, out of memory.
  Result<FrameTiming> render(const CameraView& camera, const TileGrid& grid);
  // Host memory of that resource, as FrameSlot::host.
  std::span<std::byte> host(std::string_view resource) const { return slot_.host(plan_, resource); }

 private:
  BlockingFrame() = default;

  DevicePtr device_;
  std::unique_ptr<Tracer> tracer_;
  FramePlan plan_;
  FrameSlot slot_;
  std::unique_ptr<ResidentScene> scene_;
};

}  // namespace gnomon::gpu
