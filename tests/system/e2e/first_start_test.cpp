// The first start, with nothing cached: clients that come at once are answered before the light buffers are built, and
// every frame until then, across the change and after it is the renderer's, bit for bit.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/system/e2e/daemon.h"
#include "tests/system/e2e/flier.h"
#include "tests/system/e2e/own_renderer.h"

namespace gnomon::tests {
namespace {

std::string light_buffers(const Daemon& daemon) {
  const auto status = nlohmann::json::parse(daemon.page("/status"), nullptr, false);
  for (const auto& scene : status.value("scenes", nlohmann::json::array()))
    return scene["light_buffers"].value("state", "");
  return "";
}

// With nothing in the cache. `render`: what it says beside the device.
std::string config_with(const TemporaryFolder& cache, const std::string& render) {
  std::string config = kConfig;
  const std::string usual = ", wait_for_light_buffers: true";
  config.replace(config.find(usual), usual.size(), ", cache_folder: " + cache.path().string() + render);
  return config;
}

bool answers_ready(const Daemon& daemon) { return daemon.page("/readyz") == "ready\n"; }

TEST(FirstStart, FramesAreExactBeforeTheLightBuffersAcrossTheChangeAndAfter) {
  const TemporaryFolder cache;
  const Daemon daemon(config_with(cache, ""));
  EXPECT_TRUE(answers_ready(daemon));
  client::Loop loop;
  Fliers fliers;
  fliers.push_back(std::make_unique<Flier>(loop, daemon, "studio", living_room_path()));
  fliers.push_back(std::make_unique<Flier>(loop, daemon, "arcade", living_room_path()));
  ASSERT_TRUE(all_progress(loop, fliers, 2));
  const double lights = static_cast<double>(scenes::load_scene(living_room_file()).value()->lights.size());
  EXPECT_EQ(daemon.metric("gnomon_scene_lights", {"state=\"unbuilt\""}), lights)
      << "frames came only when the light buffers were built";
  EXPECT_NE(light_buffers(daemon), "ready");

  size_t before = 0;
  while (daemon.metric("gnomon_scene_lights", {"state=\"resting\""}) < lights) {
    ASSERT_TRUE(all_progress(loop, fliers, 1));
    before = fliers[0]->frames().size();
  }
  ASSERT_TRUE(all_progress(loop, fliers, 10));
  EXPECT_EQ(light_buffers(daemon), "ready");
  EXPECT_EQ(daemon.metric("gnomon_scene_light_buffers_built_ratio"), 1);
  EXPECT_EQ(daemon.metric("gnomon_scene_light_rebuilds_total"), 0);
  EXPECT_GT(before, 3u);

  OwnRenderer own(living_room_file());
  for (const auto& flier : fliers) {
    flier->land();
    for (size_t i = 0; i < flier->frames().size(); ++i) {
      const FlierFrame& frame = flier->frames()[i];
      EXPECT_EQ(frame.words, own.render(frame.camera, kSmall))
          << "frame " << i << ", about " << before << " before";
    }
    EXPECT_EQ(flier->stream().counters().invalid_slices, 0u);
    EXPECT_EQ(flier->stream().counters().unanswered, 0u);
  }
}

TEST(FirstStart, WhoWantsToWaitsForTheLightBuffers) {
  const TemporaryFolder cache;
  const Daemon daemon(config_with(cache, ", wait_for_light_buffers: true, light_buffer_mb: 96"));
  EXPECT_TRUE(answers_ready(daemon));
  EXPECT_EQ(daemon.metric("gnomon_scene_lights", {"state=\"unbuilt\""}), 0);
  EXPECT_EQ(light_buffers(daemon), "ready");
  EXPECT_GT(daemon.metric("gnomon_scene_build_seconds"), 0);
}

}  // namespace
}  // namespace gnomon::tests
