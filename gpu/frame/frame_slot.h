// One of the frames in flight: command buffers, timestamps and the plan's resources. A slot is reused only when the
// queue's timeline has passed its last frame. All calls: the render loop's thread, unless stated otherwise.
#pragma once

#include <optional>
#include <vector>

#include "common/packed_mask.h"
#include "gpu/frame/frame_plan.h"

namespace gnomon::gpu {

struct FrameTiming {
  uint64_t begin_ns = 0;  // of the device's clock
  uint64_t total_ns = 0;
  std::vector<StageTime> stages;
};

// One band of a frame (or all of it), ready to be submitted. Valid until the slot's next frame.
struct RecordedBand {
  VkCommandBuffer commands = VK_NULL_HANDLE;
  VkQueryPool timestamps = VK_NULL_HANDLE;
};

class FrameSlot {
 public:
  // `number`: index among the frames in flight.
  static Result<FrameSlot> create(const DevicePtr& device, const FramePlan& plan, uint32_t number = 0);

  // Whether the slot's resources are large enough for a frame of `scene` and `grid`.
  bool holds(const ResidentScene& scene, const TileGrid& grid) const;
  // Makes the resources large enough; they are kept for later frames. Precondition of this and of submit: the device
  // has passed the slot's last frame. Error: out of memory; then only another reserve may follow.
  Result<void> reserve(const FramePlan& plan, const ResidentScene& scene, const TileGrid& grid);

  // Records a frame of the posed scene for a grid that was reserved: its first band, which has the uppermost `rows`. If
  // `rows` is 0, the band only rasterises. Error: out of memory or device lost; the slot stays usable.
  Result<RecordedBand> record(const FramePlan& plan, const ResidentScene& scene, const PosedScenePtr& posed,
                              const FrameView& view, uint32_t rows);
  // Records the next band of that frame: `rows` further ones. The bands before may still be on the device.
  Result<RecordedBand> record_more(const FramePlan& plan, const ResidentScene& scene, uint32_t rows);

  // Records and submits a complete frame. Returns the timeline value that marks its end.
  Result<uint64_t> submit(const FramePlan& plan, const ResidentScene& scene, const PosedScenePtr& posed,
                          const FrameView& view);

  // The timing of a band, by default the first band of the frame recorded last. Precondition: the device has passed the
  // band. Any thread.
  Result<FrameTiming> timing(const FramePlan& plan, VkQueryPool band) const;
  Result<FrameTiming> timing(const FramePlan& plan) const { return timing(plan, recordings_[0].timestamps.get()); }
  // As FramePlan::give, for the frames that are recorded until the next reserve.
  void give(const FramePlan& plan, std::string_view resource, const Buffer& buffer) {
    plan.give(*resources_, resource, buffer);
  }
  // Mapped memory of a host resource, to be written before submit or read after the device has passed the frame. Valid
  // until the next reserve; empty if the plan has no such resource.
  std::span<std::byte> host(const FramePlan& plan, std::string_view resource) const;
  // The mask that the pass 'readback' wrote for a frame of `grid`; valid as host(). Precondition: the plan has that
  // pass.
  PackedMaskView packed(const FramePlan& plan, const TileGrid& grid) const;

 private:
  struct Recording {
    VkCommandBuffer commands = VK_NULL_HANDLE;
    Owned<VkQueryPool, vkDestroyQueryPool> timestamps;
  };

  Result<void> add_recording(const FramePlan& plan);
  void write_inputs(const FramePlan& plan, const ResidentScene& scene);

  DevicePtr device_;
  Owned<VkCommandPool, vkDestroyCommandPool> pool_;
  std::vector<Recording> recordings_;  // one for each band; as many as a frame has ever had
  FrameView view_;                     // of the frame recorded last
  size_t bands_ = 0;                   // recorded so far of that frame
  uint32_t next_row_ = 0;
  std::optional<FrameResources> resources_;
  uint32_t number_ = 0;
  PosedScenePtr posed_;  // of the last frame; kept because its commands refer to it
};

// Error: the device cannot render a picture of that size.
Result<void> check_size(const Device& device, uint32_t width, uint32_t height);

}  // namespace gnomon::gpu
