#include "gpu/picture/blocking_frame.h"

#include <algorithm>

#include "gpu/raster_choice.h"

namespace gnomon::gpu {

Result<std::unique_ptr<BlockingFrame>> BlockingFrame::create(const RendererOptions& options,
                                                             const std::vector<std::string>& passes,
                                                             const scenes::ScenePtr& scene) {
  std::unique_ptr<BlockingFrame> self(new BlockingFrame);
  DeviceOptions opened{options.device, options.validation};
  opened.texel_loads = options.texel_loads;
  auto device = Device::create(opened);
  if (!device) return device.error();
  self->device_ = *device;
  if (std::find(passes.begin(), passes.end(), "trace") != passes.end()) {
    auto tracer = make_tracer(options.tracer, *device, options.tracer_options);
    if (!tracer) return tracer.error();
    self->tracer_ = std::move(*tracer);
  }
  const auto raster = choose_raster(*device, options.raster);
  if (!raster) return raster.error();
  self->raster_ = *raster;
  auto variants = PlanVariants::create(*device, with_raster(passes, *raster), self->tracer_.get(), 1);
  if (!variants) return variants.error();
  self->variants_ = std::move(*variants);
  auto resident = ResidentScene::create(*device, scene, self->tracer_.get());
  if (!resident) return resident.error();
  self->scene_ = std::move(*resident);
  return self;
}

Result<std::unique_ptr<BlockingFrame>> BlockingFrame::create_beside(const BlockingFrame& other,
                                                                    const std::vector<std::string>& passes) {
  std::unique_ptr<BlockingFrame> self(new BlockingFrame);
  self->device_ = other.device_;
  self->scene_ = other.scene_;
  self->raster_ = other.raster_;
  auto variants = PlanVariants::create(self->device_, with_raster(passes, other.raster_), nullptr, 1);
  if (!variants) return variants.error();
  self->variants_ = std::move(*variants);
  return self;
}

Result<TileGrid> BlockingFrame::reserve(uint32_t width, uint32_t height, scenes::SceneTime time,
                                        SampleCounts samples) {
  samples_ = scene_->area_lights().samples(samples);
  return make_room({width, height, scene_->area_lights().plane_count(samples_)}, time);
}

Result<TileGrid> BlockingFrame::reserve_given(const TileGrid& masks, scenes::SceneTime time) {
  samples_ = {};
  return make_room(masks, time);
}

Result<TileGrid> BlockingFrame::make_room(const TileGrid& grid, scenes::SceneTime time) {
  if (auto fits = check_size(*device_, grid.width, grid.height); !fits) return fits.error();
  if (auto passed = device_->queue().wait(started_); !passed) return passed.error();
  posed_ = scene_->pose(time);
  auto variant = variants_->variant_for(*posed_, samples_);
  if (!variant) return variant.error();
  variant_ = *variant;
  if (auto room = slot().reserve(variant_->plan, *scene_, grid); !room) return room.error();
  return grid;
}

Result<FrameTiming> BlockingFrame::render(const CameraView& camera, const TileGrid& grid) {
  if (auto begun = start(camera, grid); !begun) return begun.error();
  if (auto passed = device_->queue().wait(started_); !passed) return passed.error();
  return slot().timing(variant_->plan);
}

Result<void> BlockingFrame::start(const CameraView& camera, const TileGrid& grid) {
  const auto timeline = slot().submit(variant_->plan, *scene_, posed_, {camera, grid, {}, samples_});
  if (!timeline) return timeline.error();
  started_ = *timeline;
  return {};
}

}  // namespace gnomon::gpu
