// Renders frames of one scene in one slot and waits for each. The reference view and the surface probe use it; a server
// uses Renderer.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gpu/frame/plan_variants.h"
#include "gpu/tracers/tracer.h"
#include "gpu/vulkan_renderer.h"

namespace gnomon::gpu {

class BlockingFrame {
 public:
  // `options`' passes are replaced by `passes`; its tracer is made only if one of them traces.
  static Result<std::unique_ptr<BlockingFrame>> create(const RendererOptions& options,
                                                       const std::vector<std::string>& passes,
                                                       const scenes::ScenePtr& scene);

  // A frame with the device, scene and raster of `other` for another list of passes, none of which traces. Both must be
  // used by the same thread.
  static Result<std::unique_ptr<BlockingFrame>> create_beside(const BlockingFrame& other,
                                                              const std::vector<std::string>& passes);

  const Device& device() const { return *device_; }
  const ResidentScene& scene() const { return *scene_; }
  ResidentScene& scene() { return *scene_; }
  const Tracer* tracer() const { return tracer_.get(); }
  const DevicePtr& device_ptr() const { return device_; }

  // Makes room for a frame of the scene at `time`, so that host() can be written. `samples`: as RenderJob::samples. Error: size out of range, out of memory.
  Result<TileGrid> reserve(uint32_t width, uint32_t height, scenes::SceneTime time = {}, SampleCounts samples = {});
  // As reserve, for a frame that traces nothing and is given masks of that grid.
  Result<TileGrid> reserve_given(const TileGrid& masks, scenes::SceneTime time = {});
  // Renders what was reserved and waits. Error: device lost, out of memory.
  Result<FrameTiming> render(const CameraView& camera, const TileGrid& grid);
  // As render, but does not wait: for passes that write to given buffers, which later frames of this scene on this
  // device may read. Error: as render.
  Result<void> start(const CameraView& camera, const TileGrid& grid);
  // As FrameSlot::give.
  void give(std::string_view resource, const Buffer& buffer) { slot().give(variant_->plan, resource, buffer); }
  // As FrameSlot::host.
  std::span<std::byte> host(std::string_view resource) const { return slot().host(variant_->plan, resource); }
  // As FrameSlot::packed.
  PackedMaskView packed(const TileGrid& grid) const { return slot().packed(variant_->plan, grid); }

 private:
  BlockingFrame() = default;
  Result<TileGrid> make_room(const TileGrid& grid, scenes::SceneTime time);
  FrameSlot& slot() const { return variant_->slots[0]; }

  DevicePtr device_;
  std::unique_ptr<Tracer> tracer_;
  std::optional<PlanVariants> variants_;
  std::string raster_;
  uint64_t started_ = 0;            // the timeline's value of the last frame; 0: none
  PlanVariant* variant_ = nullptr;  // of the frame that was reserved last
  PosedScenePtr posed_;             // of the frame that was reserved last
  SampleCounts samples_;            // of the frame that was reserved last
  std::shared_ptr<ResidentScene> scene_;
};

}  // namespace gnomon::gpu
