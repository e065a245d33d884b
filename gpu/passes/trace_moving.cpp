// Traces moving lights and moving geometry, after the tracer has traced resting lights and geometry.
#include <array>

#include "gpu/passes/hierarchies.h"
#include "gpu/passes/passes.h"
#include "gpu/tracers/tracer.h"
#include "spirv/trace_moving_comp.h"

namespace gnomon::gpu {
namespace {

// As shaders/trace_moving.comp declares it.
struct Push {
  VkDeviceAddress masks, valid_bits;
  Hierarchy still, moving;
  std::array<uint32_t, kMaxLights / 32> moving_lights;
};
static_assert(sizeof(Push) <= kPushConstantBytes);

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
            {resource::kMovingBvh, Use::storage_read}};
  }

  void record(const FrameContext& frame) const override {
    if (frame.posed.at_rest()) return;
    const Push push{frame.ports[1].buffer->address(), frame.ports[2].buffer->address(),
                    resting_hierarchy(frame.posed), moving_hierarchy(frame, *frame.ports[3].buffer),
                    frame.posed.moving_lights};
    dispatch_tiles(frame, step_, std::as_bytes(std::span(&push, 1)));
  }

 private:
  ComputeStep step_;
};

}  // namespace

Result<std::unique_ptr<Pass>> make_trace_moving_pass(const DevicePtr& device) {
  return pass_of<TraceMovingPass>(make_compute_step(device, 1, trace_moving_comp));
}

}  // namespace gnomon::gpu
