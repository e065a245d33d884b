// Suite "soft": the shadow stage with 1, 4 and 16 sample points of each area light and with ambient occlusion, by the
// device's timestamps, in turn within one run; what is built for the extents; and how the queries of the light buffers
// end, counted in C++.
#include <algorithm>
#include <array>

#include "common/clock.h"
#include "gpu/tracers/light_buffer/query.h"
#include "scenes/light_samples.h"
#include "tests/bench/bench_scenes.h"
#include "tests/bench/steady_times.h"
#include "tests/bench/suites.h"
#include "tests/unit/gpu/surface_probe.h"

namespace gnomon::bench {
namespace {

using nlohmann::ordered_json;

// Hard shadows come first: the others are compared with them.
constexpr std::array<SampleCounts, 5> kSamples{
    SampleCounts{1}, {4}, {16}, {1, Occlusion::half}, {1, Occlusion::full}};
constexpr uint32_t kCountedSamples = 16;  // of the queries that are counted
constexpr uint32_t kStride = 5;           // of the pixels whose queries are counted, in both directions

// Of lights of scenes whose file says no extent of any.
constexpr float kOtherwiseMetres = 0.05f;

// Point and spot lights become spheres.
scenes::ScenePtr with_spheres(const scenes::Scene& scene, float radius) {
  auto made = std::make_shared<scenes::Scene>(scene);
  for (scenes::Light& light : made->lights) {
    if (light.type != scenes::LightType::directional)
      light.area = {scenes::LightShape::sphere, {radius, 0, 0}, {0, radius, 0}};
  }
  return made;
}

// What shadows take; of frames with occlusion, what that takes alone.
double trace_ms(const SteadyTimes& times, SampleCounts samples) {
  const bool occlusion = samples.occlusion != Occlusion::none;
  double sum = 0;
  for (const auto& [pass, ms] : times.stage_ms) {
    const bool of_occlusion = pass == "trace_occlusion";
    const bool of_shadows = !of_occlusion && (pass.starts_with("trace") || pass == "sample_points");
    if (occlusion ? of_occlusion : of_shadows) sum += ms;
  }
  return sum;
}

// How queries of area lights end, and how many pairs see a part of their light.
struct Ends {
  std::array<uint64_t, 3> by{};
  uint64_t partly = 0, steps = 0, tested = 0;

  uint64_t asked() const { return by[0] + by[1] + by[2]; }
  double share(uint64_t part) const {
    return static_cast<double>(part) / static_cast<double>(std::max<uint64_t>(asked(), 1));
  }
};

class SoftSuite : public Suite {
 public:
  void add_options(CLI::App& command) override {
    command.add_option("--scene", scenes_, "built-in name or glTF file")->capture_default_str();
    command.add_option("--size", sizes_, "pixels of the traced picture")->capture_default_str();
    command.add_option("--radius", radius_,
                       "metres, of spheres that point and spot lights become; default: the extents of the file, or "
                       "0.05 where it has none");
    command.add_option("--device", device_, "index, type or part of the name");
    command.add_option("--tracer", tracer_, "tracer to measure")->capture_default_str();
    command.add_option("--frames", frames_, "cameras along the scene's path")->capture_default_str();
    command.add_option("--repeats", repeats_, "of each frame; medians are reported")->capture_default_str();
    command.add_flag("--count", count_, "also count how queries end, with buffers that are built for that");
  }

  Result<Report> run() override {
    report_.suite = "soft";
    for (const std::string& name : scenes_) {
      say("scene " + name + ": loading");
      const auto loaded = open_scene(name);
      if (!loaded) return loaded.error();
      const bool as_in_file = radius_ == 0.0f && scenes::has_area_lights(**loaded);
      const float radius = radius_ == 0.0f ? kOtherwiseMetres : radius_;
      extents_ = as_in_file ? ordered_json("of the file") : ordered_json(radius);
      if (auto measured = measure(as_in_file ? *loaded : with_spheres(**loaded, radius)); !measured)
        return measured.error();
    }
    return std::move(report_);
  }

 private:
  Result<void> measure(const scenes::ScenePtr& scene) {
    gpu::RendererOptions options;
    options.device = device_;
    options.tracer = tracer_;
    auto frame = gpu::BlockingFrame::create(options, options.passes, scene);
    if (!frame) return frame.error();
    report_.device = (*frame)->device().info().name;
    report_.driver = (*frame)->device().info().driver;
    ordered_json built{{"memory_bytes", (*frame)->scene().traced().memory_bytes()},
                       {"build_ms", (*frame)->scene().traced().build_seconds * 1e3},
                       {"area_memory_bytes", nullptr},
                       {"area_build_ms", nullptr}};
    if ((*frame)->tracer()->soft_shader()) {
      say("  building for areas");
      auto areas = gpu::build_for_areas(*(*frame)->tracer(), *scene, scene->lights);
      if (!areas) return areas.error();
      built["area_memory_bytes"] = areas->traced->memory_bytes();
      built["area_build_ms"] = areas->traced->build_seconds * 1e3;
      (*frame)->scene().give_traced(std::move(*areas), gpu::Shadows::soft);
    }
    Ends ends;
    if (count_) {
      auto counted = count(scene);
      if (!counted) return counted.error();
      ends = *counted;
    }
    for (const std::string& text : sizes_) {
      const auto size = parse_size(text);
      if (!size) return size.error();
      if (auto r = measure_size(**frame, *scene, text, *size, built, ends); !r) return r;
    }
    return {};
  }

  Result<void> measure_size(gpu::BlockingFrame& frame, const scenes::Scene& scene, const std::string& text,
                            PictureSize size, const ordered_json& built, const Ends& ends) {
    std::array<std::vector<double>, kSamples.size()> of_cameras;
    for (const gpu::CameraView& camera : cameras_along_path(scene, std::max(1u, frames_), size)) {
      std::array<std::vector<double>, kSamples.size()> ms;
      for (uint32_t repeat = 0; repeat <= repeats_; ++repeat) {
        for (size_t i = 0; i < kSamples.size(); ++i) {
          const auto grid = frame.reserve(size.width, size.height, {}, kSamples[i]);
          if (!grid) return grid.error();
          const auto times = steady_times(frame, camera, *grid);
          if (!times) return times.error();
          if (repeat > 0) ms[i].push_back(trace_ms(*times, kSamples[i]));  // the first one warms up
        }
      }
      for (size_t i = 0; i < kSamples.size(); ++i) of_cameras[i].push_back(median(ms[i]));
    }
    for (size_t kind = 0; kind < kSamples.size(); ++kind) {
      const uint32_t samples = kSamples[kind].per_light;
      std::vector<double> ratios;
      for (size_t i = 0; i < of_cameras[kind].size(); ++i) ratios.push_back(of_cameras[kind][i] / of_cameras[0][i]);
      ordered_json row{{"scene", scene.name},
                       {"size", text},
                       {"lights", scene.lights.size()},
                       {"tracer", frame.tracer()->name()},
                       {"radius_m", extents_},
                       {"samples", samples},
                       {"occlusion", to_string(kSamples[kind].occlusion)},
                       {"trace_ms", median(of_cameras[kind])},
                       {"ratio_to_hard", median(ratios)}};
      if (samples == kCountedSamples && count_) {
        row["near_share"] = ends.share(ends.by[0]);
        row["cover_share"] = ends.share(ends.by[1]);
        row["walk_share"] = ends.share(ends.by[2]);
        row["partly_share"] = ends.share(ends.partly);
        row["steps"] = ends.share(ends.steps);
        row["tested"] = ends.share(ends.tested);
      }
      if (samples == kCountedSamples) row.update(built);
      report_.rows.push_back(std::move(row));
    }
    return {};
  }

  // Of some pixels of all cameras, with buffers built here.
  Result<Ends> count(const scenes::ScenePtr& scene) const {
    say("  counting queries");
    gpu::RendererOptions options;
    options.device = device_;
    options.tracer = "bvh";
    auto probe = gpu::SurfaceProbe::create(options, scene);
    if (!probe) return probe.error();
    const scenes::WorldMesh mesh = scenes::build_world_mesh(*scene);
    std::vector<gpu::exact::TracedLight> areas;
    std::vector<std::vector<glm::vec3>> offsets;
    for (const scenes::Light& light : scene->lights) {
      if (light.area.shape == scenes::LightShape::point) continue;
      areas.push_back(gpu::with_extent(gpu::traced_light(light, scene->bounds), light.area));
      offsets.push_back(scenes::sample_offsets(light.area, kCountedSamples));
    }
    gpu::light_buffer::BuildSettings settings;
    settings.most_work /= 16;
    const gpu::light_buffer::LightBuffer buffer = gpu::light_buffer::build(mesh, scene->bounds, areas, settings);
    const PictureSize size{480, 270};
    Ends ends;
    for (const gpu::CameraView& camera : cameras_along_path(*scene, std::max(1u, frames_), size)) {
      const auto frame = probe->render(camera, size.width, size.height);
      if (!frame) return frame.error();
      for (uint32_t y = 0; y < size.height; y += kStride)
        for (uint32_t x = 0; x < size.width; x += kStride)
          for (size_t light = 0; light < areas.size(); ++light)
            count_one(
                buffer, buffer.lights[light], mesh, camera, frame->surface_at(x, y), areas[light],
                std::span(offsets[light]).subspan(scenes::sample_pattern(x, y) * kCountedSamples, kCountedSamples),
                ends);
    }
    return ends;
  }

  static void count_one(const gpu::light_buffer::LightBuffer& buffer, const gpu::light_buffer::LightView& view,
                        const scenes::WorldMesh& mesh, const gpu::CameraView& camera,
                        const gpu::SurfaceSample& sample, const gpu::exact::TracedLight& light,
                        std::span<const glm::vec3> offsets, Ends& ends) {
    if (sample.triangle == 0) return;
    const gpu::exact::SurfacePoint surface{sample.position, sample.normal};
    const auto middle = gpu::exact::shadow_segment(camera.position, surface, light);
    if (!middle.traced) return;
    std::vector<glm::vec3> points;
    for (const glm::vec3& offset : offsets) points.push_back(light.position + offset);
    const auto answer = gpu::light_buffer::query_area(buffer, view, mesh, surface, middle.origin, points);
    ++ends.by[static_cast<size_t>(answer.end)];
    ends.partly += answer.seen > 0 && answer.seen < kCountedSamples;
    ends.steps += answer.steps;
    ends.tested += answer.tested;
  }

  std::vector<std::string> scenes_{"living_room", "temple", "sponza_crytek"};
  std::vector<std::string> sizes_{"960x540", "1920x1080"};
  float radius_ = 0.0f;
  ordered_json extents_;
  std::string device_, tracer_ = "light_buffer";
  uint32_t frames_ = 3, repeats_ = 3;
  bool count_ = false;
  Report report_;
};

}  // namespace

std::unique_ptr<Suite> make_soft_suite() { return std::make_unique<SoftSuite>(); }

}  // namespace gnomon::bench
