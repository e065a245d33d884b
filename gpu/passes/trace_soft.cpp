// Soft frames: the points of area lights that are traced, and the pass that counts how many of them each pixel sees.
#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

#include "gpu/passes/hierarchies.h"
#include "gpu/passes/passes.h"
#include "gpu/tracers/tracer.h"
#include "spirv/trace_soft_bvh_comp.h"
#include "spirv/trace_soft_bvh_texels_comp.h"

namespace gnomon::gpu {
namespace {

// As shaders/soft_lights.glsl declares it.
struct SoftLight {
  enum How : uint32_t { lit_everywhere, by_hierarchy, by_light_buffer };
  uint32_t light = 0;
  uint32_t plane = 0, planes = 0;  // of the mask
  uint32_t points = 0;             // the first of its points, pattern by pattern
  uint32_t how = by_hierarchy;
  uint32_t view = 0;  // of light buffers: its number among the area lights
  float radius = 0;
};
struct SoftFrame {
  uint32_t light_count = 0;
  uint32_t samples = 0;
  std::array<uint32_t, 2> reserved{};
  std::array<SoftLight, kMaxLights> lights;
  // and the points of all lights, in the world: vec4 where they are loaded as texels, else vec3, as an NVIDIA H200 took
  // 11% more time for 16 points of vec4 in living_room
};
static_assert(sizeof(SoftFrame) % sizeof(glm::vec4) == 0, "the points are whole texels");

uint64_t bytes_of(const Capacity& c) { return sizeof(SoftFrame) + uint64_t{c.sample_points} * sizeof(glm::vec4); }

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

// As shaders/trace_soft.glsl and, with what a tracer built for extents, shaders/trace_soft_light_buffer.comp declare it.
struct Push {
  VkDeviceAddress soft;
  Hierarchy still, moving;
};

class TraceSoftPass : public Pass {
 public:
  // `built`: traces what the tracer built for extents; without such a step hierarchies trace all area lights.
  TraceSoftPass(ComputeStep step, std::optional<ComputeStep> built, bool motion)
      : step_(std::move(step)), built_(std::move(built)), motion_(motion) {}

  std::string_view name() const override { return "trace_soft"; }
  const PassLayout* layout() const override { return &step_.layout; }
  RunsIn runs_in() const override { return RunsIn::every_band; }
  std::vector<Port> ports() const override {
    std::vector<Port> ports{{resource::kTriangleId, Use::sampled},
                            {resource::kMasks, Use::storage_update},
                            {resource::kValidBits, Use::storage_update},
                            {resource::kSoftLights, Use::texel_read}};
    if (motion_) ports.push_back({resource::kMovingBvh, Use::texel_read});
    return ports;
  }

  void record(const FrameContext& frame) const override {
    std::array<std::byte, kPushConstantBytes> push{};
    size_t bytes = 0;
    const auto add = [&](std::span<const std::byte> part) {
      std::copy(part.begin(), part.end(), push.begin() + static_cast<ptrdiff_t>(bytes));
      bytes += part.size();
    };
    const std::array words{frame.ports[1].buffer->address(), frame.ports[2].buffer->address()};
    add(std::as_bytes(std::span(words)));
    const bool by_built = built_ && frame.posed.area_traced;
    if (by_built) add(frame.posed.area_traced->push_constants());
    const Push own{frame.ports[3].buffer->address(), resting_hierarchy(frame.posed),
                   motion_ ? moving_hierarchy(frame, *frame.ports[4].buffer) : Hierarchy{}};
    add(std::as_bytes(std::span(&own, 1)));
    const BoundPort* moving = motion_ ? &frame.ports[4] : nullptr;
    const VkDescriptorSet points = frame.ports[3].texels;
    if (!by_built) return dispatch_tiles(frame, step_, push, texels_of(frame, moving, {points}));
    dispatch_tiles(frame, *built_, push, texels_of(frame, moving, {points, frame.posed.area_traced->texels()}));
  }

 private:
  ComputeStep step_;
  std::optional<ComputeStep> built_;
  bool motion_;
};

}  // namespace

void write_soft(std::span<std::byte> into, const ResidentScene& scene, const PosedScene& posed,
                const FrameView& view) {
  SoftFrame soft;
  soft.samples = view.samples.per_light;
  const size_t point_floats = scene.texels() ? 4 : 3;
  std::vector<float> points;
  uint32_t plane = 0, areas = 0;
  for (uint32_t light = 0; light < scene.light_count(); ++light) {
    const bool area = scene.area_lights().is_area(light);
    const uint32_t planes = planes_of(area ? view.samples.per_light : 1u);
    const exact::TracedLight& traced = posed.lights[light];
    if (area || view.untraced[light]) {
      const SoftLight::How how = view.untraced[light]      ? SoftLight::lit_everywhere
                                 : posed.area_built[light] ? SoftLight::by_light_buffer
                                                           : SoftLight::by_hierarchy;
      soft.lights[soft.light_count++] = {light,
                                         plane,
                                         planes,
                                         static_cast<uint32_t>(points.size() / point_floats),
                                         how,
                                         areas,
                                         with_extent(traced, posed.areas[light]).radius};
    }
    if (area) {
      for (const glm::vec3& offset :
           scene.area_lights().offsets(light, posed.areas[light], view.samples.per_light)) {
        const glm::vec4 point(traced.position + offset, 0.0f);
        points.insert(points.end(), &point.x, &point.x + point_floats);
      }
      ++areas;
    }
    plane += planes;
  }
  std::memcpy(into.data(), &soft, sizeof(soft));
  std::memcpy(into.data() + sizeof(soft), points.data(), points.size() * sizeof(float));
}

Result<std::unique_ptr<Pass>> make_sample_points_pass() {
  return std::unique_ptr<Pass>(std::make_unique<SamplePointsPass>());
}

Result<std::unique_ptr<Pass>> make_trace_soft_pass(const DevicePtr& device, const Tracer& tracer, bool motion) {
  std::optional<ComputeStep> built;
  if (const auto shader = tracer.soft_shader()) {
    auto step = make_compute_step(device, 1, shader->spirv, 0, shader->lanes, {},
                                  texel_sets(*device, {1, shader->texel_buffers}));
    if (!step) return step.error();
    step->tiles_at_once = shader->tiles;
    built = std::move(*step);
  }
  const std::array<uint32_t, 1> looks_at_points{device->features().has_vector_units()};
  return pass_of<TraceSoftPass>(
      make_compute_step(device, 1, device->features().choose(trace_soft_bvh_texels_comp, trace_soft_bvh_comp), 0, 0,
                        looks_at_points, texel_sets(*device, {1})),
      std::move(built), motion);
}

}  // namespace gnomon::gpu
