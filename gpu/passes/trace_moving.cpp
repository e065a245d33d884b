// Traces moving lights and moving geometry, after the tracer has traced resting lights and geometry.
#include <array>
#include <cstring>

#include "gpu/passes/passes.h"
#include "gpu/tracers/tracer.h"
#include "spirv/trace_moving_comp.h"

namespace gnomon::gpu {
namespace {

// As shaders/trace_moving.comp declares it.
struct Hierarchy {
  VkDeviceAddress nodes = 0;
  VkDeviceAddress triangles = 0;
  uint32_t node_count = 0;
  uint32_t first_triangle = 0;
};
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
    Push push{
        frame.ports[1].buffer->address(), frame.ports[2].buffer->address(), {}, {}, frame.posed.moving_lights};
    if (frame.posed.static_bvh) {
      const std::span<const std::byte> bytes = frame.posed.static_bvh->push_constants();
      std::memcpy(&push.still, bytes.data(), std::min(bytes.size(), sizeof(push.still)));
    }
    const uint64_t most_nodes = 2 * uint64_t{frame.scene.moving_size().triangles};
    push.moving.nodes = frame.ports[3].buffer->address();
    push.moving.triangles = push.moving.nodes + most_nodes * sizeof(BvhNode);
    push.moving.node_count = static_cast<uint32_t>(frame.posed.bvh.nodes.size());
    push.moving.first_triangle = frame.scene.moving_place(frame.slot).first_triangle;
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
