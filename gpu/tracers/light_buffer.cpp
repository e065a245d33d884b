// Tracer "light_buffer": what each light sees, built once (gpu/tracers/light_buffer/). For static geometry and lights.
#include <array>
#include <utility>

#include "common/clock.h"
#include "common/log.h"
#include "gpu/tracers/light_buffer/builder.h"
#include "gpu/tracers/light_buffer/cache.h"
#include "gpu/tracers/tracer.h"
#include "spirv/trace_light_buffer_32_comp.h"
#include "spirv/trace_light_buffer_8_comp.h"

namespace gnomon::gpu {
namespace {

// As shaders/trace_light_buffer.glsl declares it, after the addresses of the masks.
struct Push {
  VkDeviceAddress grid = 0;
  VkDeviceAddress leaves = 0;
  VkDeviceAddress entries = 0;
  VkDeviceAddress corners = 0;
  VkDeviceAddress views = 0;
  uint32_t first_masked = 0;
  uint32_t reserved = 0;
};

class LightBufferScene : public TracedScene {
 public:
  // Error: out of memory.
  static Result<std::unique_ptr<TracedScene>> create(const DevicePtr& device,
                                                     const light_buffer::LightBuffer& buffer,
                                                     const scenes::WorldMesh& mesh) {
    auto scene = std::make_unique<LightBufferScene>();
    const std::vector<glm::vec3> corners = corners_of(mesh);
    const std::array<std::pair<std::span<const std::byte>, VkDeviceAddress*>, 5> parts = {{
        {std::as_bytes(std::span(buffer.grid)), &scene->push_.grid},
        {std::as_bytes(std::span(buffer.leaves)), &scene->push_.leaves},
        {std::as_bytes(std::span(buffer.entries)), &scene->push_.entries},
        {std::as_bytes(std::span(corners)), &scene->push_.corners},
        {std::as_bytes(std::span(buffer.lights)), &scene->push_.views},
    }};
    for (const auto& [bytes, address] : parts) {
      auto uploaded = upload(device, bytes);
      if (!uploaded) return uploaded.error();
      *address = uploaded->address();
      scene->buffers_.push_back(std::move(*uploaded));
    }
    scene->push_.first_masked = mesh.opaque_count;
    return std::unique_ptr<TracedScene>(std::move(scene));
  }

  uint64_t memory_bytes() const override {
    uint64_t bytes = 0;
    for (const Buffer& buffer : buffers_) bytes += buffer.bytes();
    return bytes;
  }
  std::span<const std::byte> push_constants() const override { return std::as_bytes(std::span(&push_, 1)); }

 private:
  // Of every triangle, side by side: a walk then reads one place instead of four.
  static std::vector<glm::vec3> corners_of(const scenes::WorldMesh& mesh) {
    std::vector<glm::vec3> corners;
    corners.reserve(3 * mesh.triangles.size());
    for (const glm::uvec3& t : mesh.triangles) {
      for (int k = 0; k < 3; ++k) corners.push_back(mesh.positions[t[k]]);
    }
    return corners;
  }

  std::vector<Buffer> buffers_;
  Push push_;
};

class LightBufferTracer : public Tracer {
 public:
  LightBufferTracer(DevicePtr device, TracerOptions options)
      : device_(std::move(device)), options_(std::move(options)) {}

  std::string_view name() const override { return "light_buffer"; }
  std::span<const uint32_t> shader() const override {
    if (device_->features().subgroup_size == 8) return trace_light_buffer_8_comp;
    return trace_light_buffer_32_comp;
  }

  bool builds_for_lights() const override { return true; }

  Result<std::unique_ptr<TracedScene>> build(const TracerInput& input) const override {
    const TimePoint start = Clock::now();
    bool from_cache = false;
    const light_buffer::LightBuffer buffer = load_or_build(input, from_cache);
    auto created = LightBufferScene::create(device_, buffer, input.mesh);
    if (!created) return created.error();
    std::unique_ptr<TracedScene> scene = std::move(*created);
    scene->build_seconds = to_seconds(Clock::now() - start);
    scene->list_statistics = lists_of(buffer.statistics, from_cache);
    log_built(input.scene, buffer.statistics.bytes, *scene);
    return scene;
  }

 private:
  light_buffer::LightBuffer load_or_build(const TracerInput& input, bool& from_cache) const {
    light_buffer::BuildSettings settings;
    settings.budget_bytes = options_.light_buffer_bytes;
    if (options_.cache_folder.empty() || !input.lights_as_loaded) return build_anew(input, settings);
    const light_buffer::CacheKey key =
        light_buffer::cache_key(input.scene.content_hash, settings, input.mesh.triangles);
    std::string why;
    if (auto cached = light_buffer::load(options_.cache_folder, key, why)) {
      from_cache = true;
      return std::move(*cached);
    }
    if (!why.empty()) {
      log::warning("cached light buffer not used",
                   {{"file", light_buffer::cache_file(options_.cache_folder, key).string()}, {"reason", why}});
    }
    light_buffer::LightBuffer buffer = build_anew(input, settings);
    if (auto saved = light_buffer::save(options_.cache_folder, key, buffer); !saved) {
      log::warning("light buffer not cached", {{"reason", saved.error().message}});
    }
    return buffer;
  }

  static light_buffer::LightBuffer build_anew(const TracerInput& input, light_buffer::BuildSettings settings) {
    settings.progress = [&](double share) {
      log::info("building light buffers",
                {{"scene", input.scene.name}, {"percent", static_cast<int>(100 * share)}});
    };
    return light_buffer::build(input.mesh, input.scene.bounds, input.lights, settings);
  }

  static ListStatistics lists_of(const light_buffer::Statistics& s, bool from_cache) {
    const double average = static_cast<double>(s.entries) / static_cast<double>(std::max<uint64_t>(s.leaves, 1));
    return {average, s.longest_list, from_cache};
  }

  static void log_built(const scenes::Scene& scene, uint64_t bytes, const TracedScene& built) {
    log::info("light buffers ready", {{"scene", scene.name},
                                      {"seconds", built.build_seconds},
                                      {"bytes", bytes},
                                      {"from_cache", built.list_statistics.from_cache},
                                      {"average_list", built.list_statistics.average},
                                      {"longest_list", built.list_statistics.longest}});
  }

  DevicePtr device_;
  TracerOptions options_;
};

}  // namespace

Result<std::unique_ptr<Tracer>> make_light_buffer_tracer(const DevicePtr& device, const TracerOptions& options) {
  const uint32_t lanes = device->features().subgroup_size;
  if (lanes != 8 && lanes != 32) {
    return Error{"tracer 'light_buffer' needs subgroups of 8 or 32 lanes; the device has " + std::to_string(lanes)};
  }
  return std::unique_ptr<Tracer>(std::make_unique<LightBufferTracer>(device, options));
}

}  // namespace gnomon::gpu
