// Every tracer against Embree, over the very same shadow segments: at most 2 bits in 100,000 differ, all of them at
// shadow edges.
#include <gtest/gtest.h>

#include <sys/stat.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>

#include "scenes/light_samples.h"
#include "scenes/loader.h"
#include "tests/unit/gpu/brute_force.h"
#include "tests/unit/gpu/embree_oracle.h"
#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;
namespace fs = std::filesystem;

constexpr uint32_t kPoses = 20;
constexpr double kAllowedShare = 2e-5;

// A pose somewhere in the middle of the scene, looking anywhere.
CameraView random_view(const scenes::Bounds& bounds, std::mt19937& random, uint32_t width, uint32_t height) {
  std::uniform_real_distribution<float> inner(0.15f, 0.85f), around(-1.0f, 1.0f);
  const glm::vec3 where(inner(random), inner(random), inner(random));
  const glm::vec3 eye = bounds.min + where * (bounds.max - bounds.min);
  const glm::vec3 way(around(random), 0.5f * around(random), around(random));
  CameraView view = look_at(eye, eye + way + glm::vec3(1e-3f), 1.0f, width, height);
  view.near_plane = 1e-3f * glm::length(bounds.max - bounds.min);
  return view;
}

struct Difference {
  uint64_t bits = 0;  // of pixels with a surface
  uint64_t lit = 0;
  uint64_t differing = 0;
  uint64_t off_edge = 0;  // of these, where the oracle's neighbourhood is all alike

  void add(const ProbedFrame& frame, const TileMaskView& oracle) {
    for (uint32_t y = 0; y < frame.grid.height; ++y)
      for (uint32_t x = 0; x < frame.grid.width; ++x) {
        if (!shows(frame, x, y)) continue;
        bits += frame.grid.planes;
        for (uint32_t light = 0; light < frame.grid.planes; ++light) {
          lit += oracle.lit(x, y, light);
          if (frame.mask().lit(x, y, light) == oracle.lit(x, y, light)) continue;
          ++differing;
          off_edge += !at_edge(frame, oracle, x, y, light);
        }
      }
  }

 private:
  static bool shows(const ProbedFrame& frame, uint32_t x, uint32_t y) {
    return frame.samples[size_t{y} * frame.grid.width + x].triangle != 0;
  }
  static bool at_edge(const ProbedFrame& frame, const TileMaskView& oracle, uint32_t x, uint32_t y,
                      uint32_t light) {
    bool any_lit = false, any_dark = false;
    for (uint32_t v = y > 0 ? y - 1 : 0; v <= std::min(y + 1, frame.grid.height - 1); ++v)
      for (uint32_t u = x > 0 ? x - 1 : 0; u <= std::min(x + 1, frame.grid.width - 1); ++u)
        if (shows(frame, u, v)) (oracle.lit(u, v, light) ? any_lit : any_dark) = true;
    return any_lit && any_dark;
  }
};

// The cache folder for light buffers that this build of the program has made; those of other builds are removed. Only
// runs that test the rasteriser read the cache; all others build again, and write it.
fs::path kept_light_buffers() {
  static const fs::path folder = [] {
    struct stat program {};
    EXPECT_EQ(stat("/proc/self/exe", &program), 0);
    const fs::path all = GNOMON_TEST_CACHE;
    const fs::path own = all / (std::to_string(program.st_size) + "_" + std::to_string(program.st_mtim.tv_sec) +
                                "_" + std::to_string(program.st_mtim.tv_nsec));
    if (!std::getenv("GNOMON_TEST_RASTER") || !fs::exists(own)) fs::remove_all(all);
    return own;
  }();
  return folder;
}

// Only scenes that gpu_oracle_compute_raster uses are cached.
bool is_kept(const scenes::Scene& scene) {
  return scene.name != "oa_minia" && scene.name != "country_kitchen" && scene.name != "grey_white_room";
}

Result<SurfaceProbe> probe_of(const scenes::ScenePtr& scene, const std::string& tracer) {
  RendererOptions options = full_size_options(tracer);
  if (is_kept(*scene)) options.tracer_options.cache_folder = kept_light_buffers();
  return SurfaceProbe::create(options, scene);
}

// `oracle`: of the scene, or of the scene stopped at `time`.
void compare(SurfaceProbe& probe, const scenes::ScenePtr& scene, const EmbreeOracle& oracle,
             const std::string& tracer, scenes::SceneTime time = {}) {
  // A CPU answers ray queries slowly: fewer pixels, as many poses.
  const uint32_t width = tracer == "ray_query" ? 160 : 320, height = width * 9 / 16;
  std::mt19937 random(20);
  Difference difference;
  for (uint32_t pose = 0; pose < kPoses; ++pose) {
    const CameraView camera = random_view(scene->bounds, random, width, height);
    const auto frame = probe.render(camera, width, height, time);
    ASSERT_TRUE(frame) << frame.error().message;
    const auto words = oracle.trace(camera, frame->grid, frame->samples, EmbreeQuery::single, 2);
    difference.add(*frame, {frame->grid, words});
  }
  std::printf("%s, %s: %llu of %llu bits differ (%.2f in a million), %llu away from edges\n", scene->name.c_str(),
              tracer.c_str(), static_cast<unsigned long long>(difference.differing),
              static_cast<unsigned long long>(difference.bits),
              1e6 * static_cast<double>(difference.differing) / static_cast<double>(difference.bits),
              static_cast<unsigned long long>(difference.off_edge));
  EXPECT_LE(static_cast<double>(difference.differing), kAllowedShare * static_cast<double>(difference.bits));
  EXPECT_EQ(difference.off_edge, 0u);
  EXPECT_GT(difference.bits, uint64_t{kPoses} * width * height / 4);
  EXPECT_GT(difference.lit, difference.bits / 100);
}

class Oracle : public testing::TestWithParam<const char*> {
 protected:
  static fs::path file() {
    const fs::path built_in = fs::path(GNOMON_SCENES_DIR) / (std::string(GetParam()) + ".glb");
    if (fs::exists(built_in)) return built_in;
    return fs::path(GNOMON_SOURCE_DIR) / "../shared/scenes" / (std::string(GetParam()) + ".glb");
  }
};

TEST_P(Oracle, AgreesWithEmbree) {
  if (!fs::exists(file())) GTEST_SKIP() << "skipped: no scene " << file();
  const auto scene = scenes::load_scene(file());
  ASSERT_TRUE(scene) << scene.error().message;
  const EmbreeOracle oracle(*scene, true);
  for (const std::string& tracer : tracers()) {
    SCOPED_TRACE(tracer);
    auto probe = probe_of(*scene, tracer);
    ASSERT_TRUE(probe) << probe.error().message;
    compare(*probe, *scene, oracle, tracer);
  }
}

// Soft frames: of the points that are asked, at most as many differ, and none where the oracle's neighbours agree.
void compare_soft(SurfaceProbe& probe, const scenes::Scene& scene, const EmbreeOracle& oracle, uint32_t samples) {
  constexpr uint32_t kWidth = 160, kHeight = 90, kSoftPoses = 6;
  std::mt19937 random(21);
  uint64_t points = 0, differing = 0, partly = 0;
  const LightPlanes planes = test::planes_of(scene, samples);
  for (uint32_t pose = 0; pose < kSoftPoses; ++pose) {
    const CameraView camera = random_view(scene.bounds, random, kWidth, kHeight);
    const auto frame = probe.render(camera, kWidth, kHeight, {}, samples);
    ASSERT_TRUE(frame) << frame.error().message;
    const auto counts = oracle.count(camera, frame->grid, frame->samples, samples, 2);
    for (uint32_t light = 0; light < planes.light_count(); ++light) {
      if (planes.samples(light) == 1) continue;
      for (uint32_t y = 0; y < kHeight; ++y)
        for (uint32_t x = 0; x < kWidth; ++x) {
          const auto& expected = counts[(size_t{light} * kHeight + y) * kWidth + x];
          ASSERT_EQ(frame->care().lit(x, y, planes.first(light)), expected.has_value());
          if (!expected) continue;
          const uint32_t seen = planes.seen(frame->mask(), x, y, light);
          points += samples;
          partly += *expected > 0 && *expected < samples;
          differing += seen > *expected ? seen - *expected : *expected - seen;
        }
    }
  }
  std::printf("%s, %u samples: %llu of %llu points differ, %llu pairs see a part\n", scene.name.c_str(), samples,
              static_cast<unsigned long long>(differing), static_cast<unsigned long long>(points),
              static_cast<unsigned long long>(partly));
  EXPECT_LE(static_cast<double>(differing), kAllowedShare * static_cast<double>(points));
  EXPECT_GT(partly, 1000u);
}

TEST_P(Oracle, AgreesWithEmbreeOnAreaLights) {
  if (!fs::exists(file())) GTEST_SKIP() << "skipped: no scene " << file();
  const auto loaded = scenes::load_scene(file());
  ASSERT_TRUE(loaded) << loaded.error().message;
  // Buffers of extents take tens of seconds to build on two cores: a room and a small scene suffice.
  const std::string_view name = GetParam();
  if (name != "living_room" && name != "oa_minia") GTEST_SKIP() << "skipped: two scenes suffice";
  const auto scene = with_areas(**loaded, 0.02f * glm::length((*loaded)->bounds.max - (*loaded)->bounds.min));
  const EmbreeOracle oracle(scene, true);
  for (const std::string tracer : {"bvh", "light_buffer"}) {
    SCOPED_TRACE(tracer);
    auto probe = SurfaceProbe::create(full_size_options(tracer), scene);
    ASSERT_TRUE(probe) << probe.error().message;
    ASSERT_TRUE(probe->build_areas());
    compare_soft(*probe, *scene, oracle, 16);
    compare_soft(*probe, *scene, oracle, 4);
  }
}

TEST_P(Oracle, AgreesWithEmbreeOnAmbientOcclusion) {
  if (!fs::exists(file())) GTEST_SKIP() << "skipped: no scene " << file();
  constexpr uint32_t kWidth = 160, kHeight = 90, kOccludedPoses = 6;
  const auto scene = scenes::load_scene(file());
  ASSERT_TRUE(scene) << scene.error().message;
  const EmbreeOracle oracle(*scene, true);
  auto probe = SurfaceProbe::create(device_options("bvh"), *scene);
  ASSERT_TRUE(probe) << probe.error().message;
  const SampleCounts samples{1, Occlusion::full};
  const LightPlanes planes = test::planes_of(**scene, samples);
  const std::vector<glm::vec3> points = scenes::occlusion_points();
  const float radius = scenes::occlusion_radius(**scene);
  std::mt19937 random(22);
  uint64_t segments = 0, differing = 0, partly = 0;
  for (uint32_t pose = 0; pose < kOccludedPoses; ++pose) {
    const CameraView camera = random_view((*scene)->bounds, random, kWidth, kHeight);
    const auto frame = probe->render(camera, kWidth, kHeight, {}, samples);
    ASSERT_TRUE(frame) << frame.error().message;
    for (uint32_t y = 0; y < kHeight; ++y)
      for (uint32_t x = 0; x < kWidth; ++x) {
        const SurfaceSample& sample = frame->surface_at(x, y);
        ASSERT_EQ(frame->care().lit(x, y, planes.first_of_occlusion()), sample.triangle != 0);
        if (sample.triangle == 0) continue;
        const glm::vec3 origin = exact::segment_origin(camera.position, {sample.position, sample.normal});
        uint32_t expected = 0;
        for (uint32_t i = 0; i < kOcclusionSegments; ++i) {
          const glm::vec3& point = points[scenes::sample_pattern(x, y) * kOcclusionSegments + i];
          const auto segment = exact::occlusion_segment(origin, sample.normal, point, radius);
          expected += !segment.traced || !oracle.occluded(origin, origin + segment.direction);
        }
        const uint32_t open = planes.open_segments(frame->mask(), x, y);
        segments += kOcclusionSegments;
        partly += expected < kOcclusionSegments;
        differing += open > expected ? open - expected : expected - open;
      }
  }
  std::printf("%s: %llu of %llu segments differ, %llu pixels are occluded in part\n", (*scene)->name.c_str(),
              static_cast<unsigned long long>(differing), static_cast<unsigned long long>(segments),
              static_cast<unsigned long long>(partly));
  EXPECT_LE(static_cast<double>(differing), kAllowedShare * static_cast<double>(segments));
  EXPECT_GT(partly, 100u);
}

// Every fifth instance of the scene turns and shifts where it stands, and so does the first light.
scenes::ScenePtr set_in_motion(const scenes::Scene& scene) {
  auto moving = std::make_shared<scenes::Scene>(scene);
  const auto move = [&](const glm::mat4& where) {
    scenes::MovingNode node = swing({0, 0, 0}, {0.2f, 0.1f, -0.15f});
    node.parent_to_world = glm::dmat4(where);
    moving->moving_nodes.push_back(std::move(node));
    return static_cast<uint32_t>(moving->moving_nodes.size()) - 1;
  };
  for (size_t i = 0; i < moving->instances.size(); i += 5)
    moving->instances[i].moved_by = move(moving->instances[i].object_to_world);
  glm::mat4 lamp(1.0f);
  lamp[3] = glm::vec4(moving->lights[0].position, 1.0f);
  moving->lights[0].moved_by = move(lamp);
  moving->period = std::chrono::seconds(2);
  moving->bounds = scenes::moved_bounds(*moving, moving->bounds);
  return moving;
}

TEST(MovingOracle, AgreesWithEmbreeOverTheSceneStopped) {
  const auto file = fs::path(GNOMON_SCENES_DIR) / "living_room.glb";
  const auto scene = scenes::load_scene(file);
  ASSERT_TRUE(scene) << scene.error().message;
  const scenes::ScenePtr moving = set_in_motion(**scene);
  const std::vector<scenes::Instance> moved = scenes::moved_instances(*moving, {});
  ASSERT_GT(moved.size(), 5u);
  const scenes::SceneTime begin(0), later(1'370'000);
  const EmbreeOracle at_begin(scenes::frozen_at(*moving, begin), true);
  const EmbreeOracle at_later(scenes::frozen_at(*moving, later), true);
  for (const std::string& tracer : tracers()) {
    SCOPED_TRACE(tracer);
    auto probe = probe_of(moving, tracer);
    ASSERT_TRUE(probe) << probe.error().message;
    compare(*probe, moving, at_begin, tracer, begin);
    compare(*probe, moving, at_later, tracer, later);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Oracle,
                         testing::Values("living_room", "temple", "sponza_crytek", "oa_minia", "country_kitchen",
                                         "grey_white_room", "godot_living_room"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace gnomon::test
