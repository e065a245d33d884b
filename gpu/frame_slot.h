// One of the frames in flight: command buffer, timestamps and the plan's resources. A slot is used again only when
// the queue's timeline has passed its last frame.
#pragma once

#include <optional>
#include <vector>

#include "gpu/passes/frame_plan.h"

namespace gnomon::gpu {

struct FrameTiming {
  uint64_t total_ns = 0;
  std::vector<StageTime> stages;
};

class FrameSlot {
 public:
  static Result<FrameSlot> create(const DevicePtr& device, const FramePlan& plan);

  // Makes room for frames of `scene` and `grid`: resources only grow. Precondition of this and of submit: the slot's
  // last frame has passed. Error: out of memory; then only another reserve may follow.
  Result<void> reserve(const FramePlan& plan, const ResidentScene& scene, const TileGrid& grid);

  // Records and submits one frame of `grid`, which was reserved. Returns the timeline value. Error: out of memory or
  // device lost; the slot stays usable.
  Result<uint64_t> submit(const FramePlan& plan, const ResidentScene& scene, const CameraView& camera,
                          const TileGrid& grid);

  // Of the frame submitted last; precondition: it has passed.
  Result<FrameTiming> timing(const FramePlan& plan) const;
  // Mapped memory of a host resource: written before submit, or read after the frame has passed. Valid until the next
  // reserve. Empty: the plan has no such resource.
  std::span<std::byte> host(const FramePlan& plan, std::string_view resource) const;

 private:
  DevicePtr device_;
  Owned<VkCommandPool, vkDestroyCommandPool> pool_;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  Owned<VkQueryPool, vkDestroyQueryPool> timestamps_;
  std::optional<FrameResources> resources_;
};

// Error: the device cannot render a picture of that size.
Result<void> check_size(const Device& device, uint32_t width, uint32_t height);

}  // namespace gnomon::gpu
