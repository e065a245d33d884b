// Soft frames: the points of area lights that are traced, and the pass that counts how many of them each pixel sees.
#include <array>
#include <cstring>

#include "gpu/passes/hierarchies.h"
#include "gpu/passes/passes.h"
#include "gpu/tracers/tracer.h"
#include "spirv/trace_soft_bvh_comp.h"

namespace gnomon::gpu {
namespace {

// As shaders/trace_soft.glsl declares it.
struct SoftLight {
  enum How : uint32_t { lit_everywhere, by_hierarchy };
  uint32_t light = 0;
  uint32_t plane = 0, planes = 0;  // of the mask
  uint32_t points = 0;             // the first of its points, pattern by pattern
  uint32_t how = by_hierarchy;
};
struct SoftFrame {
  uint32_t light_count = 0;
  uint32_t samples = 0;
  std::array<SoftLight, kMaxLights> lights;
  // and the points of all lights, in the world
};

uint64_t bytes_of(const Capacity& c) { return sizeof(SoftFrame) + uint64_t{c.sample_points} * sizeof(glm::vec3); }

class SamplePointsPass : public Pass {
 public:
  std::string_view name() const override { return "sample_points"; }
  const PassLayout* layout() const override { return nullptr; }
  std::vector<Port> ports() const override {
    return {{resource::kSoftHost, Use::copy_source, {{}, bytes_of, MemoryUse::upload}},
            {resource::kSoftLights, Use::copy_target, {{}, bytes_of}}};
  }
  void record(const FrameContext& frame) const override {
    const VkBufferCopy region{0, 0, bytes_of(frame.size())};
    vkCmdCopyBuffer(frame.commands, frame.ports[0].buffer->handle(), frame.ports[1].buffer->handle(), 1, &region);
  }
};

// As shaders/trace_soft.glsl declares it.
struct Push {
  VkDeviceAddress masks, valid_bits, soft;
  Hierarchy still, moving;
};
static_assert(sizeof(Push) <= kPushConstantBytes);

class TraceSoftPass : public Pass {
 public:
  TraceSoftPass(ComputeStep step, bool motion) : step_(std::move(step)), motion_(motion) {}

  std::string_view name() const override { return "trace_soft"; }
  const PassLayout* layout() const override { return &step_.layout; }
  RunsIn runs_in() const override { return RunsIn::every_band; }
  std::vector<Port> ports() const override {
    std::vector<Port> ports{{resource::kTriangleId, Use::sampled},
                            {resource::kMasks, Use::storage_update},
                            {resource::kValidBits, Use::storage_update},
                            {resource::kSoftLights, Use::storage_read}};
    if (motion_) ports.push_back({resource::kMovingBvh, Use::storage_read});
    return ports;
  }

  void record(const FrameContext& frame) const override {
    const Push push{frame.ports[1].buffer->address(), frame.ports[2].buffer->address(),
                    frame.ports[3].buffer->address(), resting_hierarchy(frame.posed),
                    motion_ ? moving_hierarchy(frame, *frame.ports[4].buffer) : Hierarchy{}};
    dispatch_tiles(frame, step_, std::as_bytes(std::span(&push, 1)));
  }

 private:
  ComputeStep step_;
  bool motion_;
};

}  // namespace

void write_soft(std::span<std::byte> into, const ResidentScene& scene, const PosedScene& posed,
                const FrameView& view) {
  SoftFrame soft;
  soft.samples = view.samples;
  std::vector<glm::vec3> points;
  uint32_t plane = 0;
  for (uint32_t light = 0; light < scene.light_count(); ++light) {
    const bool area = scene.area_lights().is_area(light);
    const uint32_t planes = planes_of(area ? view.samples : 1);
    if (area || view.untraced[light]) {
      soft.lights[soft.light_count++] = {
          light, plane, planes, static_cast<uint32_t>(points.size()),
          view.untraced[light] ? SoftLight::lit_everywhere : SoftLight::by_hierarchy};
    }
    if (area) {
      for (const glm::vec3& offset : scene.area_lights().offsets(light, posed.areas[light], view.samples))
        points.push_back(posed.lights[light].position + offset);
    }
    plane += planes;
  }
  std::memcpy(into.data(), &soft, sizeof(soft));
  std::memcpy(into.data() + sizeof(soft), points.data(), points.size() * sizeof(glm::vec3));
}

Result<std::unique_ptr<Pass>> make_sample_points_pass() {
  return std::unique_ptr<Pass>(std::make_unique<SamplePointsPass>());
}

Result<std::unique_ptr<Pass>> make_trace_soft_pass(const DevicePtr& device, const Tracer&, bool motion) {
  return pass_of<TraceSoftPass>(make_compute_step(device, 1, trace_soft_bvh_comp), motion);
}

}  // namespace gnomon::gpu
