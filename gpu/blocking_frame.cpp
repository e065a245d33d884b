#include "gpu/blocking_frame.h"

#include <algorithm>

namespace gnomon::gpu {

Result<std::unique_ptr<BlockingFrame>> BlockingFrame::create(const RendererOptions& options,
                                                             const std::vector<std::string>& passes,
                                                             const scenes::ScenePtr& scene) {
  std::unique_ptr<BlockingFrame> self(new BlockingFrame);
  auto device = Device::create({options.device, options.validation});
  if (!device) return device.error();
  self->device_ = *device;
  if (std::find(passes.begin(), passes.end(), "trace") != passes.end()) {
    auto tracer = make_tracer(options.tracer, *device, options.tracer_options);
    if (!tracer) return tracer.error();
    self->tracer_ = std::move(*tracer);
  }
  auto plan = FramePlan::compile(*device, passes, self->tracer_.get());
  if (!plan) return plan.error();
  self->plan_ = std::move(*plan);
  auto slot = FrameSlot::create(*device, self->plan_);
  if (!slot) return slot.error();
  self->slot_ = std::move(*slot);
  auto resident = ResidentScene::create(*device, scene, self->tracer_.get());
  if (!resident) return resident.error();
  self->scene_ = std::move(*resident);
  return self;
}

Result<TileGrid> BlockingFrame::reserve(uint32_t width, uint32_t height) {
  const TileGrid grid{width, height, scene_->light_count()};
  if (auto fits = check_size(*device_, width, height); !fits) return fits.error();
  if (auto room = slot_.reserve(plan_, *scene_, grid); !room) return room.error();
  return grid;
}

Result<FrameTiming> BlockingFrame::render(const CameraView& camera, const TileGrid& grid) {
  const auto timeline = slot_.submit(plan_, *scene_, camera, grid);
  if (!timeline) return timeline.error();
  if (auto passed = device_->queue().wait(*timeline); !passed) return passed.error();
  return slot_.timing(plan_);
}

}  // namespace gnomon::gpu
