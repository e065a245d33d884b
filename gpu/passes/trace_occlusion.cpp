// The occlusion of the ambient light: for each pixel that counts it, how many segments nothing near blocks.
#include <array>
#include <cstring>
#include <vector>

#include "gpu/passes/hierarchies.h"
#include "gpu/passes/passes.h"
#include "scenes/light_samples.h"
#include "spirv/trace_occlusion_comp.h"
#include "spirv/trace_occlusion_texels_comp.h"

namespace gnomon::gpu {
namespace {

// As shaders/trace_occlusion.comp declares them.
struct OcclusionPush {
  VkDeviceAddress masks, valid_bits, points;
  uint32_t first_plane;
  uint32_t half_size;
  Hierarchy still, moving;
};
static_assert(sizeof(OcclusionPush) <= kPushConstantBytes);

uint64_t points_bytes(const Capacity&) {
  return sizeof(float) + scenes::kSamplePatterns * kOcclusionSegments * sizeof(glm::vec3);
}

class TraceOcclusionPass : public Pass {
 public:
  TraceOcclusionPass(ComputeStep step, bool motion) : step_(std::move(step)), motion_(motion) {}

  std::string_view name() const override { return "trace_occlusion"; }
  const PassLayout* layout() const override { return &step_.layout; }
  RunsIn runs_in() const override { return RunsIn::every_band; }
  std::vector<Port> ports() const override {
    std::vector<Port> ports{{resource::kTriangleId, Use::sampled},
                            {resource::kMasks, Use::storage_update},
                            {resource::kValidBits, Use::storage_update},
                            {resource::kOcclusionPoints, Use::storage_read, {{}, points_bytes, MemoryUse::upload}}};
    if (motion_) ports.push_back({resource::kMovingBvh, Use::texel_read});
    return ports;
  }

  void record(const FrameContext& frame) const override {
    const OcclusionPush push{frame.ports[1].buffer->address(),
                             frame.ports[2].buffer->address(),
                             frame.ports[3].buffer->address(),
                             frame.grid.planes - planes_of(frame.samples.occlusion),
                             frame.samples.occlusion == Occlusion::half,
                             resting_hierarchy(frame.posed),
                             motion_ ? moving_hierarchy(frame, *frame.ports[4].buffer) : Hierarchy{}};
    dispatch_tiles(frame, step_, std::as_bytes(std::span(&push, 1)),
                   texels_of(frame, motion_ ? &frame.ports[4] : nullptr));
  }

 private:
  ComputeStep step_;
  bool motion_;
};

}  // namespace

void write_occlusion(std::span<std::byte> into, const scenes::Scene& scene) {
  static const std::vector<glm::vec3> points = scenes::occlusion_points();
  const float radius = scenes::occlusion_radius(scene);
  std::memcpy(into.data(), &radius, sizeof(radius));
  std::memcpy(into.data() + sizeof(radius), points.data(), points.size() * sizeof(glm::vec3));
}

Result<std::unique_ptr<Pass>> make_trace_occlusion_pass(const DevicePtr& device, bool motion) {
  return pass_of<TraceOcclusionPass>(
      make_compute_step(device, 1, device->features().choose(trace_occlusion_texels_comp, trace_occlusion_comp), 0,
                        0, {}, texel_sets(*device)),
      motion);
}

}  // namespace gnomon::gpu
