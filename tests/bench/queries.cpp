// Suite "queries": what a light buffer's queries cost, counted and not timed. Every pair of a pixel with a surface and
// a light that has to be traced is asked in C++, step by step as the shader does.
#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "gpu/scene/resident_scene.h"
#include "gpu/tracers/light_buffer/builder.h"
#include "gpu/tracers/light_buffer/query.h"
#include "tests/bench/bench_scenes.h"
#include "tests/bench/suites.h"
#include "tests/unit/gpu/surface_probe.h"

namespace gnomon::bench {
namespace {

namespace light_buffer = gpu::light_buffer;

struct Counts {
  uint64_t pairs = 0;  // asked
  uint64_t near = 0, cover = 0, walks = 0;
  uint64_t steps = 0, tests = 0;  // of the walks
  double blocker_first = 0;  // the price of all pairs if walks begin with what blocked the tile's last dark one
  double together = 0;       // the price of all pairs if 32 lanes wait for each other
  double worst = 0;          // of a tile's lanes: what the end of a frame may wait for

  void operator+=(const Counts& other) {
    pairs += other.pairs;
    near += other.near;
    cover += other.cover;
    walks += other.walks;
    steps += other.steps;
    tests += other.tests;
    blocker_first += other.blocker_first;
    together += other.together;
    worst = std::max(worst, other.worst);
  }
  void add(const light_buffer::Answer& answer) {
    ++pairs;
    near += answer.end == light_buffer::End::near_plane;
    cover += answer.end == light_buffer::End::cover_plane;
    walks += answer.end == light_buffer::End::list;
    steps += answer.steps;
    tests += answer.tested;
  }
};

double percent(uint64_t part, uint64_t whole) {
  return whole ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}
double each(uint64_t sum, uint64_t count) {
  return count ? static_cast<double>(sum) / static_cast<double>(count) : 0.0;
}

class QueriesSuite : public Suite {
 public:
  void add_options(CLI::App& command) override {
    command.add_option("--scene", scenes_, "built-in name, one made for benches, or glTF file; default: all");
    command.add_option("--size", size_text_, "pixels of the picture")->capture_default_str();
    command.add_option("--frames", frames_, "cameras along the scene's path")->capture_default_str();
    command.add_option("--budget-mb", budget_mb_, "memory of a scene's light buffers; 0: the default")
        ->capture_default_str();
    command.add_option("--cost-per-byte", cost_per_byte_, "finest detail; 0: the default")->capture_default_str();
  }

  Result<Report> run() override {
    const auto size = parse_size(size_text_);
    if (!size) return size.error();
    report_.suite = "queries";
    if (scenes_.empty()) scenes_ = all_scenes();
    for (const std::string& name : scenes_) {
      say("scene " + name);
      const auto scene = open_scene(name);
      if (!scene) return scene.error();
      if (auto measured = measure(*scene, *size); !measured) return measured.error();
    }
    return std::move(report_);
  }

 private:
  Result<void> measure(const scenes::ScenePtr& scene, PictureSize size) {
    const scenes::WorldMesh mesh = scenes::build_world_mesh(*scene);
    std::vector<gpu::exact::TracedLight> lights;
    for (const scenes::Light& light : scene->lights) lights.push_back(gpu::traced_light(light, scene->bounds));
    light_buffer::BuildSettings settings;
    if (cost_per_byte_ > 0) settings.detail.cost_per_byte = cost_per_byte_;
    settings.budget_bytes = uint64_t{budget_mb_} << 20;
    const light_buffer::LightBuffer buffer = light_buffer::build(mesh, scene->bounds, lights, settings);

    gpu::RendererOptions options;
    options.tracer = "bvh";  // its masks are not used
    auto probe = gpu::SurfaceProbe::create(options, scene);
    if (!probe) return probe.error();
    Counts counts;
    for (const gpu::CameraView& camera : cameras_along_path(*scene, std::max(1u, frames_), size)) {
      const auto frame = probe->render(camera, size.width, size.height);
      if (!frame) return frame.error();
      counts += ask_all(buffer, mesh, lights, camera, *frame);
    }
    add_row(*scene, buffer, counts);
    return {};
  }

  // A subgroup of 32 lanes traces a tile: a lane has two of its pixels, and walks their lists one after the other.
  static constexpr uint32_t kLanes = 32;
  static constexpr uint64_t kStart = 3, kTest = 3;  // of a walk; for each of its steps 1
  static double price(const light_buffer::Answer& answer) {
    const uint64_t walk = kStart + answer.steps + kTest * answer.tested;
    return answer.end == light_buffer::End::list ? static_cast<double>(walk) : 0.0;
  }

  // Of a pair that tries that blocker before it walks, and leaves its own behind.
  static double price_after(std::optional<uint32_t>& blocker, const light_buffer::Answer& answer,
                            const scenes::WorldMesh& mesh, const gpu::exact::ShadowSegment& segment) {
    if (answer.end != light_buffer::End::list) return 0.0;
    const double trying = blocker ? double{kTest} : 0.0;
    const bool spared = blocker && !answer.lit && meets(mesh, *blocker, segment);
    if (!spared && !answer.lit) blocker = answer.blocker;
    return trying + (spared ? double{kStart} : price(answer));
  }

  static bool meets(const scenes::WorldMesh& mesh, uint32_t triangle, const gpu::exact::ShadowSegment& segment) {
    const glm::uvec3 t = mesh.triangles[triangle];
    return gpu::exact::segment_meets_triangle(segment.origin, segment.direction, mesh.positions[t.x],
                                              mesh.positions[t.y], mesh.positions[t.z]);
  }

  Counts ask_all(const light_buffer::LightBuffer& buffer, const scenes::WorldMesh& mesh,
                 const std::vector<gpu::exact::TracedLight>& lights, const gpu::CameraView& camera,
                 const gpu::ProbedFrame& frame) const {
    Counts counts;
    for (uint32_t tile = 0; tile < frame.grid.tile_count(); ++tile) {
      std::array<double, kLanes> lanes{};
      std::vector<std::optional<uint32_t>> blockers(lights.size());  // of the last pairs that lists left dark
      for (uint32_t p = 0; p < 64; ++p) {
        const uint32_t x = tile % frame.grid.tiles_x() * 8 + p % 8, y = tile / frame.grid.tiles_x() * 8 + p / 8;
        if (x >= frame.grid.width || y >= frame.grid.height) continue;
        const gpu::SurfaceSample& sample = frame.samples[size_t{y} * frame.grid.width + x];
        if (sample.triangle == 0) continue;
        for (size_t l = 0; l < lights.size(); ++l) {
          const gpu::exact::ShadowSegment segment =
              gpu::exact::shadow_segment(camera.position, {sample.position, sample.normal}, lights[l]);
          if (!segment.traced) continue;
          const light_buffer::Answer answer = light_buffer::query(buffer, buffer.lights[l], mesh, segment);
          counts.add(answer);
          lanes[p % kLanes] += price(answer);
          counts.blocker_first += price_after(blockers[l], answer, mesh, segment);
        }
      }
      const double longest = *std::ranges::max_element(lanes);
      counts.together += kLanes * longest;
      counts.worst = std::max(counts.worst, longest);
    }
    return counts;
  }

  void add_row(const scenes::Scene& scene, const light_buffer::LightBuffer& buffer, const Counts& c) {
    const light_buffer::Statistics& s = buffer.statistics;
    report_.rows.push_back({{"scene", scene.name},
                            {"triangles", scene.triangle_count},
                            {"lights", scene.lights.size()},
                            {"near_percent", percent(c.near, c.pairs)},
                            {"cover_percent", percent(c.cover, c.pairs)},
                            {"walk_percent", percent(c.walks, c.pairs)},
                            {"steps_per_walk", each(c.steps, c.walks)},
                            {"tests_per_walk", each(c.tests, c.walks)},
                            {"steps_per_pair", each(c.steps, c.pairs)},
                            {"tests_per_pair", each(c.tests, c.pairs)},
                            {"price_per_pair", each(kStart * c.walks + c.steps + kTest * c.tests, c.pairs)},
                            {"price_blocker_first", c.pairs ? c.blocker_first / static_cast<double>(c.pairs) : 0.0},
                            {"price_together", c.pairs ? c.together / static_cast<double>(c.pairs) : 0.0},
                            {"worst_lane", c.worst},
                            {"longest_list", s.longest_list},
                            {"leaves", s.leaves},
                            {"entries", s.entries},
                            {"memory_mb", static_cast<double>(s.bytes) / (1 << 20)},
                            {"build_s", s.build_seconds}});
  }

  std::vector<std::string> scenes_;
  std::string size_text_ = "960x540";
  uint32_t frames_ = 3;
  uint32_t budget_mb_ = 0;
  double cost_per_byte_ = 0;
  Report report_;
};

}  // namespace

std::unique_ptr<Suite> make_queries_suite() { return std::make_unique<QueriesSuite>(); }

}  // namespace gnomon::bench
