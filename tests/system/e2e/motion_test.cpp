// A scene in which things move: all clients see one clock and the same lights, their masks are those of the scene
// stopped at the moment that the frame names, and so are the pictures that they shade.
#include <gtest/gtest.h>

#include <cmath>
#include <future>
#include <set>

#include "client/view/client_renderer.h"
#include "gpu/vulkan_renderer.h"
#include "gpu/wire/translate.h"
#include "tests/system/e2e/daemon.h"
#include "tests/system/e2e/flier.h"
#include "tests/unit/scenes/support/gltf_file.h"

namespace gnomon::tests {
namespace {

namespace made = scenes::testing;

// A floor, a block, a beam that turns above it within two seconds; a lamp that rests and one that swings.
std::string moving_hall() {
  made::GltfFile file;
  const auto box = [&](glm::vec3 half) {
    std::vector<glm::vec3> corners;
    for (int i = 0; i < 8; ++i)
      corners.push_back({i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z});
    const std::vector<uint16_t> indices{0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                        2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    const int positions = file.add_positions(corners);
    const int faces = file.add_accessor(indices, made::kUnsignedShort, "SCALAR");
    return file.add_mesh({{"attributes", {{"POSITION", positions}}}, {"indices", faces}});
  };
  file.add_node({{"mesh", box({4, 0.1f, 4})}});
  file.add_node({{"mesh", box({0.4f, 0.5f, 0.4f})}, {"translation", {1, 0.6f, 0}}, {"name", "block"}});
  file.add_node({{"mesh", box({1.6f, 0.1f, 0.3f})}, {"translation", {0, 1.6f, 0}}});
  const made::json bulb = {{"type", "point"}, {"intensity", 60}};
  file.add_lamp(bulb, {{"translation", {0.5f, 3.5f, 1}}});
  file.add_lamp(bulb, {{"translation", {-2, 3, 0}}});
  const float q = std::sqrt(0.5f);
  made::animate<glm::vec4>(file, 2, "rotation", "LINEAR", {0, 1, 2}, {{0, 0, 0, 1}, {0, q, 0, q}, {0, 1, 0, 0}});
  made::animate<glm::vec3>(file, 4, "translation", "CUBICSPLINE", {0, 2},
                           {glm::vec3(0), {-2, 3, 0}, {2, 0, 3}, {-1, 0, 2}, {1, 3, -1}, glm::vec3(0)});
  return file.gltf();
}

const std::vector<scenes::NodeMotion> kShove{
    {"block", scenes::NodeMotion::Kind::shift, {-1.5f, 0, 0.5f}, std::chrono::milliseconds(1500)}};

// The operator has the block shoved.
struct Hall {
  explicit Hall(const std::string& scenes_keys, const std::string& tracer = "auto")
      : file(folder.write("hall.gltf", moving_hall())),
        scene(scenes::load_scene(file, {}, kShove).value()),
        daemon(R"(
server: {mode: demo, state_folder: state, listen: 127.0.0.1, control_port: 0, data_port: 0}
admin: {listen: 127.0.0.1, port: 0}
render: {device: cpu, tracer: )" +
               tracer + R"(}
scenes:
  list:
    - name: hall
      file: )" +
               file.string() + R"(
      moving: [{node: block, shift: [-1.5, 0, 0.5], period_ms: 1500}]
  )" + scenes_keys +
               R"(
tenants:
  - {name: studio}
  - {name: arcade}
)") {}

  std::unique_ptr<Flier> flier(client::Loop& loop, const std::string& tenant) {
    return std::make_unique<Flier>(loop, daemon, tenant, client::CameraPath::of_scene(scene), kSmall, "hall");
  }

  made::ScratchFolder folder;
  std::filesystem::path file;
  scenes::ScenePtr scene;
  Daemon daemon;
};

std::vector<uint64_t> masks_of(const scenes::ScenePtr& scene, const protocol::CameraView& camera) {
  gpu::RendererOptions options;
  options.device = "cpu";
  options.tracer = "bvh";
  auto renderer = gpu::make_renderer(options).value();
  if (!renderer->make_resident(SceneId{0}, scene)) return {};
  std::promise<std::vector<uint64_t>> words;
  const gpu::RenderJob job{JobId{0}, SceneId{0}, gpu::from_wire(camera), kSmall.width, kSmall.height};
  const auto submitted =
      renderer->submit(job, [&](gpu::FrameDone done) { words.set_value(unpacked(done.mask.mask())); });
  return submitted ? words.get_future().get() : std::vector<uint64_t>{};
}

// The scene as a client finds it at a frame's moment, at rest.
std::shared_ptr<scenes::Scene> stopped_at(const scenes::Scene& scene, const FlierFrame& frame) {
  auto with_lights = scene;
  for (size_t i = 0; i < scene.lights.size(); ++i) {
    with_lights.lights[i] = gpu::from_wire(frame.lights.at(i));
    with_lights.lights[i].moved_by = scene.lights[i].moved_by;
  }
  return scenes::frozen_at(with_lights, scenes::SceneTime(frame.moment.scene_time_us));
}

void expect_as_stopped(const scenes::Scene& scene, const FlierFrame& frame) {
  EXPECT_EQ(frame.words, masks_of(stopped_at(scene, frame), frame.camera)) << frame.moment.scene_time_us << " us";
}

TEST(Motion, EveryFrameIsTheSceneAtTheMomentItNames) {
  Hall hall("clock_hz: 5");
  client::Loop loop;
  Fliers fliers;
  fliers.push_back(hall.flier(loop, "studio"));
  fliers.push_back(hall.flier(loop, "arcade"));
  std::set<uint32_t> times;
  ASSERT_TRUE(loop.run_until(Clock::now() + kPatience, [&] {
    times.clear();
    for (const auto& flier : fliers)
      for (const FlierFrame& frame : flier->frames()) times.insert(frame.moment.scene_time_us);
    return times.size() >= 6;
  }));
  std::set<uint32_t> seen_by_both;
  for (const FlierFrame& a : fliers[0]->frames())
    for (const FlierFrame& b : fliers[1]->frames())
      if (a.moment == b.moment) seen_by_both.insert(a.moment.scene_time_us);
  EXPECT_GE(seen_by_both.size(), 3u) << "one clock for all";
  for (const auto& flier : fliers) {
    flier->land();
    std::set<uint32_t> checked;
    for (const FlierFrame& frame : flier->frames())
      if (checked.insert(frame.moment.scene_time_us).second) expect_as_stopped(*hall.scene, frame);
    EXPECT_GE(checked.size(), 3u);
  }
}

TEST(Motion, ByTheWallClockNodesShowOneMoment) {
  using WallClock = std::chrono::system_clock;
  Hall hall("clock: wall\n  clock_hz: 1000");
  client::Loop loop;
  Fliers fliers;
  fliers.push_back(hall.flier(loop, "studio"));
  const auto before = std::chrono::duration_cast<scenes::SceneTime>(WallClock::now().time_since_epoch());
  ASSERT_TRUE(all_progress(loop, fliers, 1));
  const auto after = std::chrono::duration_cast<scenes::SceneTime>(WallClock::now().time_since_epoch());
  const scenes::SceneTime shown(fliers[0]->frames()[0].moment.scene_time_us), step(1000);
  EXPECT_LE(scenes::within_period(*hall.scene, shown - before + step), after - before + step);
}

TEST(Motion, APictureIsThatOfTheSceneStopped) {
  Hall hall("clock_hz: 20");
  client::Loop loop;
  Fliers fliers;
  fliers.push_back(hall.flier(loop, "studio"));
  ASSERT_TRUE(all_progress(loop, fliers, 8));
  gpu::RendererOptions options;
  options.device = "cpu";
  auto own = gpu::ReferenceView::create(options, hall.scene);
  ASSERT_TRUE(own) << own.error().message;
  const auto& frames = fliers[0]->frames();
  for (const FlierFrame* frame : {&frames[1], &frames[7]}) {
    const auto stopped = stopped_at(*hall.scene, *frame);
    auto other = gpu::ReferenceView::create(options, stopped);
    ASSERT_TRUE(other) << other.error().message;
    const TileGrid grid{kSmall.width, kSmall.height, 2};
    const std::vector<uint64_t> words = masks_of(stopped, frame->camera);
    gpu::ShadeOptions shade;
    const auto expected =
        (*other)->render(gpu::from_wire(frame->camera), grid.width, grid.height, {grid, words}, shade);
    shade.time = scenes::SceneTime(frame->moment.scene_time_us);
    const auto picture =
        (*own)->render(gpu::from_wire(frame->camera), grid.width, grid.height, {grid, frame->words}, shade);
    ASSERT_TRUE(expected && picture);
    EXPECT_EQ(picture->rgba, expected->rgba) << frame->moment.scene_time_us;
    EXPECT_GT(std::set<uint8_t>(picture->rgba.begin(), picture->rgba.end()).size(), 20u);
  }
}

TEST(Motion, TheClientFindsTheServersScene) {
  Hall hall("clock_hz: 60");
  const auto [status, output] =
      run("gnomon-client",
          {"--server", hall.daemon.server(), "--pin", hall.daemon.pin(), "--tenant", "studio", "--scene", "hall",
           "--scene-dir", hall.folder.path().string(), "--size", "160x90", "--frames", "4"});
  EXPECT_EQ(status, 0) << output;
}

TEST(Motion, AChangedLightIsToldToAllAndRestsAgain) {
  Hall hall("light_rest_ms: 300");
  client::Loop loop;
  Fliers fliers;
  fliers.push_back(hall.flier(loop, "studio"));
  fliers.push_back(hall.flier(loop, "arcade"));
  ASSERT_TRUE(all_progress(loop, fliers, 2));
  EXPECT_EQ(hall.daemon.metric("gnomon_scene_lights", {"state=\"resting\""}), 1);
  EXPECT_EQ(hall.daemon.metric("gnomon_scene_lights", {"state=\"moving\""}), 1);

  const auto status =
      hall.daemon.post("/scenes/hall/lights/0", R"({"position": [-1, 3, 1.5], "color": [1, 0.5, 0]})");
  EXPECT_NE(status.find("202"), std::string::npos) << status;
  const auto all_of_version_1 = [&] {
    return std::all_of(fliers.begin(), fliers.end(),
                       [](const auto& flier) { return flier->frames().back().moment.lights_version == 1; });
  };
  ASSERT_TRUE(loop.run_until(Clock::now() + kPatience, all_of_version_1));
  ASSERT_TRUE(all_progress(loop, fliers, 2));
  for (const auto& flier : fliers) {
    const FlierFrame& frame = flier->frames().back();
    EXPECT_EQ(frame.lights.at(0).position, (protocol::Vec3{-1, 3, 1.5f}));
    EXPECT_EQ(frame.lights.at(0).color, (protocol::Vec3{1, 0.5f, 0}));
    expect_as_stopped(*hall.scene, frame);
  }
  ASSERT_TRUE(loop.run_until(Clock::now() + kPatience,
                             [&] { return hall.daemon.metric("gnomon_scene_light_rebuilds_total") == 1; }));
  EXPECT_EQ(hall.daemon.metric("gnomon_scene_lights", {"state=\"resting\""}), 1);
  ASSERT_TRUE(all_progress(loop, fliers, 2));
  for (const auto& flier : fliers) expect_as_stopped(*hall.scene, flier->frames().back());

  // Who comes later finds the lights as they are.
  Fliers late;
  late.push_back(hall.flier(loop, "studio"));
  ASSERT_TRUE(all_progress(loop, late, 1));
  EXPECT_EQ(late[0]->frames()[0].moment.lights_version, 1u);
  EXPECT_EQ(late[0]->frames()[0].lights.at(0).position, (protocol::Vec3{-1, 3, 1.5f}));
}

TEST(Motion, ChangesThatCannotBeAreRefused) {
  Hall hall("", "bvh");
  const auto status = [&](const std::string& path, const std::string& body) {
    return hall.daemon.post(path, body).substr(9, 3);
  };
  EXPECT_EQ(status("/scenes/attic/lights/0", "{}"), "404");
  EXPECT_EQ(status("/scenes/hall/lights/2", "{}"), "404");
  EXPECT_EQ(status("/scenes/hall/lights/99999999999999999999", "{}"), "404");
  EXPECT_EQ(status("/scenes/hall/lights/0", "{"), "400");
  EXPECT_EQ(status("/scenes/hall/lights/1", R"({"position": [0, 0, 0]})"), "409");
  EXPECT_EQ(status("/scenes/hall/lights/1", R"({"intensity": 3})"), "202");
}

}  // namespace
}  // namespace gnomon::tests
