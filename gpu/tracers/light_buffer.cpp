// Tracer "light_buffer": what each light sees, built once (gpu/tracers/light_buffer/). For static geometry and lights.
#include "common/clock.h"
#include "common/log.h"
#include "gpu/resident_scene.h"
#include "gpu/tracers/light_buffer/builder.h"
#include "gpu/tracers/tracer.h"
#include "spirv/trace_light_buffer_32_comp.h"
#include "spirv/trace_light_buffer_8_comp.h"

namespace gnomon::gpu {
namespace {

// As shaders/trace_light_buffer.glsl declares it, after the address of the masks.
struct Push {
  VkDeviceAddress nodes = 0;
  VkDeviceAddress lists = 0;
  VkDeviceAddress views = 0;
  uint32_t first_masked = 0;
  uint32_t reserved = 0;
};

class LightBufferScene : public TracedScene {
 public:
  LightBufferScene(Buffer nodes, Buffer lists, Buffer views, uint32_t first_masked)
      : nodes_(std::move(nodes)), lists_(std::move(lists)), views_(std::move(views)) {
    push_ = {nodes_.address(), lists_.address(), views_.address(), first_masked, 0};
  }
  uint64_t memory_bytes() const override { return nodes_.bytes() + lists_.bytes() + views_.bytes(); }
  std::span<const std::byte> push_constants() const override { return std::as_bytes(std::span(&push_, 1)); }

 private:
  Buffer nodes_, lists_, views_;
  Push push_;
};

class LightBufferTracer : public Tracer {
 public:
  explicit LightBufferTracer(DevicePtr device) : device_(std::move(device)) {}

  std::string_view name() const override { return "light_buffer"; }
  std::span<const uint32_t> shader() const override {
    if (device_->features().subgroup_size == 8) return trace_light_buffer_8_comp;
    return trace_light_buffer_32_comp;
  }

  Result<std::unique_ptr<TracedScene>> build(const TracerInput& input) const override {
    const TimePoint start = Clock::now();
    std::vector<exact::TracedLight> lights;
    for (const scenes::Light& light : input.scene.lights) lights.push_back(traced_light(light, input.scene.bounds));
    const light_buffer::LightBuffer buffer = light_buffer::build(input.mesh, input.scene.bounds, lights, {});
    auto nodes = upload(device_, std::as_bytes(std::span(buffer.nodes)));
    if (!nodes) return nodes.error();
    auto lists = upload(device_, std::as_bytes(std::span(buffer.lists)));
    if (!lists) return lists.error();
    auto views = upload(device_, std::as_bytes(std::span(buffer.lights)));
    if (!views) return views.error();
    std::unique_ptr<TracedScene> scene = std::make_unique<LightBufferScene>(
        std::move(*nodes), std::move(*lists), std::move(*views), input.mesh.opaque_count);
    scene->build_seconds = to_seconds(Clock::now() - start);
    log_built(input.scene, buffer.statistics, scene->build_seconds);
    return scene;
  }

 private:
  static void log_built(const scenes::Scene& scene, const light_buffer::Statistics& s, double seconds) {
    const double average = static_cast<double>(s.entries) / static_cast<double>(std::max<uint64_t>(s.leaves, 1));
    log::info("light buffers built", {{"scene", scene.name},
                                      {"seconds", seconds},
                                      {"bytes", s.bytes},
                                      {"average_list", average},
                                      {"longest_list", s.longest_list}});
  }

  DevicePtr device_;
};

}  // namespace

std::unique_ptr<Tracer> make_light_buffer_tracer(const DevicePtr& device) {
  return std::make_unique<LightBufferTracer>(device);
}

}  // namespace gnomon::gpu
