// Tracer "light_buffer": for each light, lists of what can block it, built once (gpu/tracers/light_buffer/). It is for
// static geometry and lights.
#include <algorithm>
#include <array>
#include <future>
#include <iterator>
#include <optional>
#include <utility>

#include "common/clock.h"
#include "common/log.h"
#include "common/within_memory.h"
#include "gpu/tracers/light_buffer/builder.h"
#include "gpu/tracers/light_buffer/cache.h"
#include "gpu/tracers/light_buffer_shaders.h"
#include "gpu/tracers/tracer.h"
#include "gpu/vulkan/texels.h"
#include "scenes/light_samples.h"

namespace gnomon::gpu {
namespace {

// As shaders/trace_light_buffer.glsl declares it, after the addresses of the masks and of valid_bits.
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
  // `by_texels`: for shaders that read it so. Error: out of memory.
  static Result<std::unique_ptr<TracedScene>> create(const DevicePtr& device,
                                                     const light_buffer::LightBuffer& buffer,
                                                     const scenes::WorldMesh& mesh, bool by_texels) {
    auto scene = std::make_unique<LightBufferScene>();
    scene->push_.first_masked = mesh.opaque_count;
    auto uploaded = scene->upload_addressed(device, std::as_bytes(std::span(buffer.lights)), scene->push_.views);
    if (uploaded)
      uploaded = by_texels ? scene->upload_texels(device, buffer) : scene->upload_rest(device, buffer, mesh);
    if (!uploaded) return uploaded.error();
    return std::unique_ptr<TracedScene>(std::move(scene));
  }

  uint64_t memory_bytes() const override {
    uint64_t bytes = 0;
    for (const Buffer& buffer : buffers_) bytes += buffer.bytes();
    return bytes;
  }
  std::span<const std::byte> push_constants() const override { return std::as_bytes(std::span(&push_, 1)); }
  VkDescriptorSet texels() const override { return texels_.handle(); }

 private:
  Result<void> upload_addressed(const DevicePtr& device, std::span<const std::byte> bytes,
                                VkDeviceAddress& address) {
    auto uploaded = upload(device, bytes);
    if (!uploaded) return uploaded.error();
    address = uploaded->address();
    buffers_.push_back(std::move(*uploaded));
    return {};
  }

  Result<void> upload_rest(const DevicePtr& device, const light_buffer::LightBuffer& buffer,
                           const scenes::WorldMesh& mesh) {
    const std::vector<TriangleCorners> corners = corners_of(mesh);
    auto done = upload_addressed(device, std::as_bytes(std::span(buffer.grid)), push_.grid);
    if (done) done = upload_addressed(device, std::as_bytes(std::span(buffer.leaves)), push_.leaves);
    if (done) done = upload_addressed(device, std::as_bytes(std::span(buffer.entries)), push_.entries);
    if (done) done = upload_addressed(device, std::as_bytes(std::span(corners)), push_.corners);
    return done;
  }

  // The corners are the resident scene's. What a walk looks at of every entry lies apart from what it needs of a few.
  Result<void> upload_texels(const DevicePtr& device, const light_buffer::LightBuffer& buffer) {
    std::array<Buffer, 4> parts;
    const auto put = [&](size_t part, const auto& list) -> Result<void> {
      auto uploaded = upload(device, std::as_bytes(std::span(list)));
      if (!uploaded) return uploaded.error();
      parts[part] = std::move(*uploaded);
      return {};
    };
    if (auto done = put(0, buffer.grid); !done) return done;
    if (auto done = put(1, buffer.leaves); !done) return done;
    if (auto done = put(2, bounds_of(buffer.entries)); !done) return done;
    if (auto done = put(3, triangles_of(buffer.entries)); !done) return done;
    auto texels = TexelSet::create(device, {{{parts[0], VK_FORMAT_R32_UINT},
                                             {parts[1], VK_FORMAT_R32G32B32A32_UINT},
                                             {parts[2], VK_FORMAT_R32G32B32A32_UINT},
                                             {parts[3], VK_FORMAT_R32_UINT}}});
    if (!texels) return texels.error();
    texels_ = std::move(*texels);
    std::move(parts.begin(), parts.end(), std::back_inserter(buffers_));
    return {};
  }

  // Two to a texel.
  static std::vector<glm::uvec2> bounds_of(const std::vector<light_buffer::ListEntry>& entries) {
    std::vector<glm::uvec2> bounds((entries.size() + 1) / 2 * 2);
    std::transform(entries.begin(), entries.end(), bounds.begin(), [](const light_buffer::ListEntry& entry) {
      return glm::uvec2(entry.depth_and_low, entry.high_and_strip);
    });
    return bounds;
  }

  static std::vector<uint32_t> triangles_of(const std::vector<light_buffer::ListEntry>& entries) {
    std::vector<uint32_t> triangles(entries.size());
    std::transform(entries.begin(), entries.end(), triangles.begin(),
                   [](const light_buffer::ListEntry& entry) { return entry.triangle; });
    return triangles;
  }

  // As shaders/tracers/light_buffer.glsl has them.
  struct TriangleCorners {
    glm::vec3 p0, p1, p2;
  };

  // The corners of every triangle, side by side, so that a walk reads one place in memory instead of four.
  static std::vector<TriangleCorners> corners_of(const scenes::WorldMesh& mesh) {
    std::vector<TriangleCorners> corners;
    corners.reserve(mesh.triangles.size());
    for (const glm::uvec3& t : mesh.triangles)
      corners.push_back({mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]});
    return corners;
  }

  std::vector<Buffer> buffers_;
  TexelSet texels_;
  Push push_;
};

class LightBufferTracer : public Tracer {
 public:
  LightBufferTracer(DevicePtr device, const TraceShader& shader, std::optional<TraceShader> soft,
                    TracerOptions options)
      : device_(std::move(device)),
        shader_(shader),
        soft_shader_(soft),
        options_(std::move(options)),
        hierarchies_(make_bvh_tracer(device_, options_.builds)) {}

  std::string_view name() const override { return "light_buffer"; }
  TraceShader shader() const override { return shader_; }
  std::optional<TraceShader> soft_shader() const override { return soft_shader_; }

  bool builds_for_lights() const override { return true; }

  Result<std::unique_ptr<TracedScene>> build(const TracerInput& input) const override {
    const TimePoint start = Clock::now();
    if (auto cached = load(input)) return upload_built(input, *cached, start, true);
    const auto buffer =
        options_.builds->light_buffer(input.mesh, input.scene.bounds, input.lights, settings_for(input));
    if (!buffer) return buffer.error();
    // A thread, if one can be had, keeps it while the device gets it.
    const auto when = is_cached(input) ? std::launch::async | std::launch::deferred : std::launch::deferred;
    auto keeping = std::async(when, [&] {
      bool kept = false;
      done_or_dropped("keeping light buffers", [&] { kept = save(input, *buffer); });
      return kept;
    });
    auto scene = upload_built(input, *buffer, start, false);
    const bool kept = keeping.get();
    if (scene) (*scene)->list_statistics.not_kept = !kept;
    return scene;
  }

  Result<std::unique_ptr<TracedScene>> build_hierarchy(const TracerInput& input) const override {
    return hierarchies_->build(input);
  }

  Result<std::unique_ptr<TracedScene>> build_at_once(const TracerInput& input) const override {
    if (input.mesh.triangles.size() * input.lights.size() <= kShortBuild) return build(input);
    const TimePoint start = Clock::now();
    const auto cached = load(input);
    if (!cached) return std::unique_ptr<TracedScene>();
    return upload_built(input, *cached, start, true);
  }

 private:
  static constexpr uint64_t kAreaShare = 16;
  // Triangles x lights up to which a build takes some milliseconds only.
  static constexpr size_t kShortBuild = 20'000;

  // The hard and the soft shader are made alike.
  bool by_texels() const { return shader_.texel_buffers > 0; }
  // Of words, by one view of a buffer: no part of a light buffer may be larger.
  uint64_t shown_bytes() const { return uint64_t{device_->features().max_texels} * sizeof(uint32_t); }

  light_buffer::BuildSettings settings_for(const TracerInput& input) const {
    light_buffer::BuildSettings settings;
    const uint64_t parts = scenes::has_area_lights(input.scene) ? 2 : 1;
    const uint64_t room = light_buffer_room(device_->info(), options_) / parts;
    settings.budget_bytes = options_.light_buffer_bytes != 0
                                ? options_.light_buffer_bytes / parts
                                : light_buffer::default_budget(input.lights.size(), room);
    if (by_texels()) settings.budget_bytes = std::min(settings.budget_bytes, shown_bytes());
    // Lists for areas do not become shorter than what lies within the light's reach, so that work on them pays off less.
    const bool for_areas = std::any_of(input.lights.begin(), input.lights.end(),
                                       [](const exact::TracedLight& light) { return light.radius > 0.0f; });
    if (for_areas) settings.most_work /= kAreaShare;
    settings.stop = input.watch.stop;
    settings.progress = [&input, said = size_t{0}](size_t light, double share) mutable {
      if (light == said && !input.mesh.triangles.empty()) {
        log::info("building light buffers",
                  {{"scene", input.scene.name}, {"light", light + 1}, {"of", input.lights.size()}});
      }
      said = light + 1;
      if (input.watch.progress) input.watch.progress(light, share);
    };
    return settings;
  }

  // Builds for lights that were moved are many, and none is likely to be asked for again.
  bool is_cached(const TracerInput& input) const {
    return !options_.cache_folder.empty() && input.lights_as_loaded;
  }

  light_buffer::CacheKey key_of(const TracerInput& input) const {
    return light_buffer::cache_key(input.scene.content_hash, settings_for(input), input.mesh, input.scene.bounds,
                                   input.lights);
  }

  std::optional<light_buffer::LightBuffer> load(const TracerInput& input) const {
    if (!is_cached(input)) return std::nullopt;
    const light_buffer::CacheKey key = key_of(input);
    std::string why;
    auto cached = light_buffer::load(options_.cache_folder, key, why);
    if (!cached && !why.empty()) {
      log::warning("cached light buffer not used",
                   {{"file", light_buffer::cache_file(options_.cache_folder, key).string()}, {"reason", why}});
    }
    return cached;
  }

  // False if the cache should have taken it and did not.
  bool save(const TracerInput& input, const light_buffer::LightBuffer& buffer) const {
    if (!is_cached(input)) return true;
    const auto saved = light_buffer::save(options_.cache_folder, key_of(input), buffer, cache_limit(options_));
    if (!saved) {
      log::warning("light buffer not cached", {{"scene", input.scene.name}, {"reason", saved.error().message}});
    }
    return bool(saved);
  }

  Result<std::unique_ptr<TracedScene>> upload_built(const TracerInput& input,
                                                    const light_buffer::LightBuffer& buffer, TimePoint start,
                                                    bool from_cache) const {
    auto created = LightBufferScene::create(device_, buffer, input.mesh, by_texels());
    if (!created) return created.error();
    std::unique_ptr<TracedScene> scene = std::move(*created);
    scene->build_seconds = to_seconds(Clock::now() - start);
    scene->list_statistics = lists_of(buffer.statistics, from_cache);
    if (!input.mesh.triangles.empty()) log_built(input.scene, buffer.statistics.bytes, *scene);
    return scene;
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
  TraceShader shader_;
  std::optional<TraceShader> soft_shader_;
  TracerOptions options_;
  std::unique_ptr<Tracer> hierarchies_;
};

}  // namespace

Result<std::unique_ptr<Tracer>> make_light_buffer_tracer(const DevicePtr& device, const TracerOptions& options) {
  std::optional<TraceShader> shader = options.light_buffer_shader;
  if (!shader) shader = light_buffer_shader(device->features());
  if (!shader) {
    return Error{"tracer 'light_buffer' needs subgroups of 4 to 128 lanes with ballots and votes; the device has " +
                 std::to_string(device->features().subgroups.usual) + " lanes"};
  }
  if (!options.cache_folder.empty()) {  // the limit may be lower than it was
    const auto trimmed = light_buffer::trim(options.cache_folder, cache_limit(options));
    if (trimmed.files > 0) log::info("cache trimmed", {{"files", trimmed.files}, {"bytes", trimmed.bytes}});
  }
  const auto soft = options.light_buffer_soft_shader
                        ? options.light_buffer_soft_shader
                        : light_buffer_soft_shader(shader->lanes, shader->texel_buffers > 0);
  return std::unique_ptr<Tracer>(std::make_unique<LightBufferTracer>(device, *shader, soft, options));
}

}  // namespace gnomon::gpu
