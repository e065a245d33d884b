// One of the frames in flight: command buffer, timestamps and the plan's resources. A slot is used again only when
// the queue's timeline has passed its last frame.
#pragma once

#include <optional>
#include <vector>

#include "gpu/passes/frame_plan.h"

namespace gnomon::gpu {

// Nanoseconds of one pass, by the device's timestamps. The name lives as long as the program.
struct FrameTiming {
  uint64_t total_ns = 0;
  std::vector<StageTime> stages;
};

class FrameSlot {
 public:
  static Result<FrameSlot> create(const DevicePtr& device, const FramePlan& plan);

  // Records and submits one frame; precondition: the slot's last frame has passed. Resources grow when a frame needs
  // more than any before. Returns the timeline value. Error: out of memory or device lost; the slot stays usable.
  Result<uint64_t> submit(const FramePlan& plan, const ResidentScene& scene, const CameraView& camera,
                          uint32_t width, uint32_t height);

  // Of the frame submitted last; precondition: it has passed.
  Result<FrameTiming> timing(const FramePlan& plan) const;
  // Mapped memory of a host resource of that frame; valid until the next submit.
  std::span<const std::byte> host(const FramePlan& plan, std::string_view resource) const;

 private:
  Result<void> ensure(const FramePlan& plan, const Capacity& capacity);

  DevicePtr device_;
  Owned<VkCommandPool, vkDestroyCommandPool> pool_;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  Owned<VkQueryPool, vkDestroyQueryPool> timestamps_;
  std::optional<FrameResources> resources_;
};

}  // namespace gnomon::gpu
