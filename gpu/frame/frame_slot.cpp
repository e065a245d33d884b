#include "gpu/frame/frame_slot.h"

#include <algorithm>
#include <cstring>

#include "gpu/passes/passes.h"

namespace gnomon::gpu {

Result<FrameSlot> FrameSlot::create(const DevicePtr& device, const FramePlan& plan, uint32_t number) {
  FrameSlot slot;
  slot.number_ = number;
  slot.device_ = device;
  VkCommandPoolCreateInfo pool{};
  pool.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
  pool.queueFamilyIndex = device->queue().family();
  VkCommandPool pool_handle = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateCommandPool(device->handle(), &pool, nullptr, &pool_handle); r != VK_SUCCESS)
    return vulkan_error(r, "creating a command pool");
  slot.pool_ = {device, pool_handle};
  if (auto added = slot.add_recording(plan); !added) return added.error();
  return slot;
}

Result<void> FrameSlot::add_recording(const FramePlan& plan) {
  Recording added;
  VkCommandBufferAllocateInfo allocate{};
  allocate.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
  allocate.commandPool = pool_.get();
  allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  allocate.commandBufferCount = 1;
  if (const VkResult r = vkAllocateCommandBuffers(device_->handle(), &allocate, &added.commands); r != VK_SUCCESS)
    return vulkan_error(r, "allocating a command buffer");
  VkQueryPoolCreateInfo queries{};
  queries.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO;
  queries.queryType = VK_QUERY_TYPE_TIMESTAMP;
  queries.queryCount = static_cast<uint32_t>(plan.pass_count() + 1);
  VkQueryPool handle = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateQueryPool(device_->handle(), &queries, nullptr, &handle); r != VK_SUCCESS)
    return vulkan_error(r, "creating a query pool");
  added.timestamps = {device_, handle};
  recordings_.push_back(std::move(added));
  return {};
}

bool FrameSlot::holds(const ResidentScene& scene, const TileGrid& grid) const {
  return resources_ && resources_->capacity.holds(frame_size(scene, grid));
}

Result<void> FrameSlot::reserve(const FramePlan& plan, const ResidentScene& scene, const TileGrid& grid) {
  device_->collect();
  if (holds(scene, grid)) return {};
  const Capacity needed = frame_size(scene, grid);
  const Capacity old = resources_ ? resources_->capacity : Capacity{};
  resources_.reset();
  auto made = plan.allocate(old.grown_to(needed));
  if (!made) made = plan.allocate(needed);
  if (made) {
    resources_ = std::move(*made);
    return {};
  }
  if (old.width > 0) {  // frames that fitted before still fit
    if (auto as_before = plan.allocate(old)) resources_ = std::move(*as_before);
  }
  return made.error();
}

namespace {

// Area lights of soft frames are left to trace_soft.
void set_planes(FrameUniforms& uniforms, const ResidentScene& scene, uint32_t samples) {
  uint32_t plane = 0;
  for (uint32_t light = 0; light < scene.light_count(); ++light) {
    const bool soft = samples > 1 && scene.area_lights().is_area(light);
    uniforms.planes[light] = soft ? kLeftOut : plane;
    plane += soft ? planes_of(samples) : 1;
  }
}

}  // namespace

void FrameSlot::write_inputs(const FramePlan& plan, const ResidentScene& scene) {
  FrameUniforms uniforms{};
  set_view(uniforms, view_.camera, view_.grid.width, view_.grid.height);
  scene.describe(uniforms, *posed_);
  set_planes(uniforms, scene, view_.samples.per_light);
  const exact::TracedLight silenced = silenced_light(scene.scene().bounds);
  const auto silence = [&] {
    for (size_t i = 0; i < uniforms.light_count; ++i) {
      if (view_.untraced[i]) uniforms.lights[i] = silenced;
    }
  };
  silence();
  std::memcpy(resources_->uniforms.mapped(), &uniforms, sizeof(uniforms));
  if (resources_->resting_uniforms.mapped()) {
    // The same frame for the passes that leave moving lights to others (Pass::for_resting_lights).
    std::copy(posed_->resting_lights.begin(), posed_->resting_lights.end(), uniforms.lights);
    silence();
    std::memcpy(resources_->resting_uniforms.mapped(), &uniforms, sizeof(uniforms));
  }
  if (const auto moving = host(plan, resource::kMovingHost); !moving.empty())
    write_moving(moving, scene, *posed_, number_);
  if (const auto soft = host(plan, resource::kSoftHost); !soft.empty()) write_soft(soft, scene, *posed_, view_);
  if (const auto points = host(plan, resource::kOcclusionPoints); !points.empty())
    write_occlusion(points, scene.scene());
}

Result<RecordedBand> FrameSlot::record(const FramePlan& plan, const ResidentScene& scene,
                                       const PosedScenePtr& posed, const FrameView& view, uint32_t rows) {
  posed_ = posed;
  view_ = view;
  write_inputs(plan, scene);
  if (const VkResult r = vkResetCommandPool(device_->handle(), pool_.get(), 0); r != VK_SUCCESS)
    return vulkan_error(r, "resetting a command pool");
  bands_ = 0;
  next_row_ = 0;
  return record_more(plan, scene, rows);
}

Result<RecordedBand> FrameSlot::record_more(const FramePlan& plan, const ResidentScene& scene, uint32_t rows) {
  if (bands_ == recordings_.size()) {
    if (auto added = add_recording(plan); !added) return added.error();
  }
  const Recording& recording = recordings_[bands_];
  VkCommandBufferBeginInfo begin{};
  begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  if (const VkResult r = vkBeginCommandBuffer(recording.commands, &begin); r != VK_SUCCESS)
    return vulkan_error(r, "recording a frame");
  plan.execute(recording.commands, *resources_, {scene, *posed_, view_, number_},
               {{next_row_, rows}, bands_ == 0, next_row_ + rows == view_.grid.tiles_y()},
               recording.timestamps.get());
  if (const VkResult r = vkEndCommandBuffer(recording.commands); r != VK_SUCCESS)
    return vulkan_error(r, "recording a frame");
  ++bands_;
  next_row_ += rows;
  return RecordedBand{recording.commands, recording.timestamps.get()};
}

Result<uint64_t> FrameSlot::submit(const FramePlan& plan, const ResidentScene& scene, const PosedScenePtr& posed,
                                   const FrameView& view) {
  const auto frame = record(plan, scene, posed, view, view.grid.tiles_y());
  if (!frame) return frame.error();
  return device_->queue().submit({&frame->commands, 1});
}

Result<FrameTiming> FrameSlot::timing(const FramePlan& plan, VkQueryPool band) const {
  std::vector<uint64_t> ticks(plan.pass_count() + 1);
  const VkResult r = vkGetQueryPoolResults(device_->handle(), band, 0, static_cast<uint32_t>(ticks.size()),
                                           ticks.size() * sizeof(uint64_t), ticks.data(), sizeof(uint64_t),
                                           VK_QUERY_RESULT_64_BIT);
  if (r != VK_SUCCESS) return vulkan_error(r, "reading timestamps");
  const auto ns = [&](uint64_t from, uint64_t to) {
    return static_cast<uint64_t>(static_cast<double>(to - from) * device_->features().timestamp_period_ns);
  };
  FrameTiming timing;
  timing.begin_ns = ns(0, ticks.front());
  timing.total_ns = ns(ticks.front(), ticks.back());
  for (size_t pass = 0; pass < plan.pass_count(); ++pass)
    timing.stages.push_back({plan.pass_name(pass), ns(ticks[pass], ticks[pass + 1])});
  return timing;
}

std::span<std::byte> FrameSlot::host(const FramePlan& plan, std::string_view resource) const {
  const Buffer* buffer = plan.buffer(*resources_, resource);
  if (!buffer) return {};
  return {buffer->mapped(), buffer->bytes()};
}

PackedMaskView FrameSlot::packed(const FramePlan& plan, const TileGrid& grid) const {
  const auto* classes = reinterpret_cast<const uint32_t*>(host(plan, resource::kHostClasses).data());
  const auto* mixed = reinterpret_cast<const uint64_t*>(host(plan, resource::kHostMixed).data());
  const auto* count = reinterpret_cast<const uint32_t*>(host(plan, resource::kHostMixedCount).data());
  return {grid, {classes, PackedMaskView::class_words(grid)}, {mixed, *count}};
}

Result<void> check_size(const Device& device, uint32_t width, uint32_t height) {
  const uint32_t most = device.features().max_image_side;
  if (width >= 1 && height >= 1 && width <= most && height <= most) return {};
  return Error{"a frame of " + std::to_string(width) + "x" + std::to_string(height) +
               " pixels: the device renders from 1x1 to " + std::to_string(most) + "x" + std::to_string(most)};
}

}  // namespace gnomon::gpu
