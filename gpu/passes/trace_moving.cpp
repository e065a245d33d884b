// Traces moving lights and moving geometry, after the tracer has traced resting lights and geometry.
#include <algorithm>
#include <array>

#include "gpu/passes/hierarchies.h"
#include "gpu/passes/passes.h"
#include "gpu/tracers/tracer.h"
#include "spirv/trace_moving_comp.h"
#include "spirv/trace_moving_texels_comp.h"

namespace gnomon::gpu {
namespace {

// As shaders/trace_moving.comp declares it.
struct Push {
  VkDeviceAddress masks, valid_bits;
  Hierarchy still, moving;
  VkDeviceAddress parts;
  uint32_t part_count;
  std::array<uint32_t, kMaxLights / 32> moving_lights;
};
static_assert(offsetof(Push, moving_lights) == 76 && sizeof(Push) <= kPushConstantBytes);

static_assert(kMostParts <= 32, "the shader has a bit of a word for each");

constexpr uint32_t kFewestLanes = 4;  // for which the shader has registers

// How the subgroups of a workgroup divide its tiles.
struct Sharing {
  uint32_t lanes = 0;      // of a subgroup
  uint32_t subgroups = 1;  // of a workgroup
  uint32_t per_tile = 1;   // subgroups
};

// Lanes as the tracer "light_buffer" chooses them (gpu/tracers/light_buffer_shaders.h). On a processor the parts are best
// looked at once for a whole tile. A GPU waits for its longest walks: each lane has one pixel, and workgroups are as large
// as a multiprocessor needs to be full, as it takes a limited number of them.
Sharing sharing_for(const Device& device) {
  const SubgroupFeatures& subgroups = device.features().subgroups;
  const uint32_t lanes = std::clamp(16u, subgroups.least, subgroups.most);
  if (device.info().type == VK_PHYSICAL_DEVICE_TYPE_CPU) return {lanes};
  const uint32_t per_tile = std::max(1u, 64 / lanes);
  return {lanes, std::max(per_tile, 128 / lanes), per_tile};
}

class TraceMovingPass : public Pass {
 public:
  explicit TraceMovingPass(ComputeStep step) : step_(std::move(step)) {}

  std::string_view name() const override { return "trace_moving"; }
  const PassLayout* layout() const override { return &step_.layout; }
  RunsIn runs_in() const override { return RunsIn::every_band; }
  std::vector<Port> ports() const override {
    return {{resource::kTriangleId, Use::sampled},
            {resource::kMasks, Use::storage_update},
            {resource::kValidBits, Use::storage_update},
            {resource::kMovingBvh, Use::texel_read}};
  }

  void record(const FrameContext& frame) const override {
    if (frame.posed.at_rest()) return;
    const Buffer& moving_bvh = *frame.ports[3].buffer;
    const Push push{frame.ports[1].buffer->address(), frame.ports[2].buffer->address(),
                    resting_hierarchy(frame.posed),   moving_hierarchy(frame, moving_bvh),
                    moving_parts(frame, moving_bvh),  static_cast<uint32_t>(frame.posed.parts.size()),
                    frame.posed.moving_lights};
    dispatch_tiles(frame, step_, std::as_bytes(std::span(&push, 1)), texels_of(frame, &frame.ports[3]));
  }

 private:
  ComputeStep step_;
};

}  // namespace

Result<std::unique_ptr<Pass>> make_trace_moving_pass(const DevicePtr& device) {
  const Sharing sharing = sharing_for(*device);
  if (sharing.lanes < kFewestLanes)
    return Error{"tracing what moves needs subgroups of " + std::to_string(kFewestLanes) +
                 " lanes; the device has them of " + std::to_string(sharing.lanes)};
  const std::array constants{sharing.lanes * sharing.subgroups, sharing.lanes, sharing.per_tile};
  auto step = make_compute_step(device, 1, device->features().choose(trace_moving_texels_comp, trace_moving_comp),
                                0, sharing.lanes, constants, texel_sets(*device));
  if (step) step->tiles_at_once = sharing.subgroups / sharing.per_tile;
  return pass_of<TraceMovingPass>(std::move(step));
}

}  // namespace gnomon::gpu
