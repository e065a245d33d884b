// What arrives is what the renderer makes of that camera, bit for bit; and the reference client makes pictures of it.
#include <gtest/gtest.h>

#include <future>
#include <nlohmann/json.hpp>
#include <set>

#include "client/png.h"
#include "client/view/own_view.h"
#include "gpu/vulkan_renderer.h"
#include "tests/e2e/daemon.h"
#include "tests/e2e/flier.h"

namespace gnomon::tests {
namespace {

namespace fs = std::filesystem;

// The masks of one camera, without a network.
std::vector<uint64_t> render(gpu::Renderer& renderer, const protocol::CameraView& camera,
                             const client::ViewSize& size) {
  auto words = std::make_shared<std::promise<std::vector<uint64_t>>>();
  gpu::RenderJob job;
  job.camera = client::to_gpu(camera);
  job.width = size.traced_width();
  job.height = size.traced_height();
  const auto submitted =
      renderer.submit(job, [words](gpu::FrameDone done) { words->set_value(unpacked(done.mask.mask())); });
  EXPECT_TRUE(submitted) << submitted.error().message;
  return submitted ? words->get_future().get() : std::vector<uint64_t>{};
}

TEST(Exact, ReceivedMasksAreTheRenderersBitForBit) {
  const Daemon daemon;
  const auto scene = scenes::load_scene(living_room_file());
  ASSERT_TRUE(scene);
  gpu::RendererOptions options;
  options.device = "cpu";
  auto renderer = gpu::make_renderer(options);
  ASSERT_TRUE(renderer) << renderer.error().message;
  const auto resident = (*renderer)->make_resident(SceneId{0}, *scene);
  ASSERT_TRUE(resident) << resident.error().message;

  client::Loop loop;
  const client::ViewSize odd{.width = 150, .height = 83, .border_x = 32, .border_y = 18};
  Fliers fliers;
  fliers.push_back(std::make_unique<Flier>(loop, daemon, "studio", living_room_path()));
  fliers.push_back(std::make_unique<Flier>(loop, daemon, "arcade", living_room_path(), odd));
  ASSERT_TRUE(all_progress(loop, fliers, 6));
  for (size_t i = 0; i < fliers.size(); ++i) {
    fliers[i]->land();
    const client::ViewSize size = i == 0 ? kSmall : odd;
    size_t lit = 0, dark = 0;
    for (const auto& frame : fliers[i]->frames()) {
      EXPECT_EQ(frame.words, render(**renderer, frame.camera, size));
      for (const uint64_t word : frame.words) ++(word ? lit : dark);
    }
    EXPECT_GT(lit, 0u);
    EXPECT_GT(dark, 0u);
  }
}

// A picture for each light and kind, of the picture's size and with more than one colour of the legend.
TEST(Client, ShowsWhatTheTracerDoes) {
  const Daemon daemon;
  for (const std::string kind : {"mask", "bounds", "lists"}) {
    const TemporaryFolder folder;
    const auto [status, output] =
        run("gnomon-client", {"--server", daemon.server(), "--pin", daemon.pin(), "--tenant", "studio", "--scene",
                              "living_room", "--size", "160x90", "--frames", "1", "--pictures", "1", "--view", kind,
                              "--out", folder.path().string()});
    ASSERT_EQ(status, 0) << output;
    size_t lights = 0;
    for (const auto& entry : fs::directory_iterator(folder.path())) {
      if (entry.path().filename().string().rfind(kind + "_", 0) != 0) continue;
      const auto picture = client::read_png(entry.path());
      ASSERT_TRUE(picture) << picture.error().message;
      EXPECT_EQ(picture->width, 160u);
      EXPECT_EQ(picture->height, 90u);
      std::set<std::array<uint8_t, 3>> colours;
      for (size_t i = 0; i < picture->rgba.size(); i += 4)
        colours.insert({picture->rgba[i], picture->rgba[i + 1], picture->rgba[i + 2]});
      EXPECT_GT(colours.size(), 2u) << entry.path();
      EXPECT_LT(colours.size(), 11u) << entry.path();
      ++lights;
    }
    EXPECT_EQ(lights, scenes::load_scene(living_room_file()).value()->lights.size());
  }
}

// Colours of a picture, coarsely.
size_t distinct_colours(const client::Picture& picture) {
  std::set<uint32_t> colours;
  for (size_t i = 0; i < picture.rgba.size(); i += 4) {
    colours.insert(picture.rgba[i] / 16u << 8 | picture.rgba[i + 1] / 16u << 4 | picture.rgba[i + 2] / 16u);
  }
  return colours.size();
}

TEST(Client, LeavesPicturesAndFigures) {
  const Daemon daemon;
  for (const std::string mode : {"sequential", "queued"}) {
    const TemporaryFolder folder;
    const auto json = folder.path() / "client.json";
    const auto [status, output] =
        run("gnomon-client", {"--server", daemon.server(), "--pin",       daemon.pin(), "--tenant",
                              "studio",   "--scene",       "living_room", "--size",     "160x90",
                              "--border", "32x18",         "--frames",    "3",          "--pictures",
                              "1",        "--mode",        mode,          "--out",      folder.path().string(),
                              "--json",   json.string()});
    ASSERT_EQ(status, 0) << output;
    size_t shaded = 0, lights = 0;
    for (const auto& entry : fs::directory_iterator(folder.path())) {
      if (entry.path().extension() != ".png") continue;
      const auto picture = client::read_png(entry.path());
      ASSERT_TRUE(picture) << picture.error().message;
      EXPECT_GT(distinct_colours(*picture), 30u) << entry.path();
      const bool is_frame = entry.path().filename().string().rfind("frame_", 0) == 0;
      ++(is_frame ? shaded : lights);
      if (is_frame) {
        EXPECT_EQ(picture->width, 160u);
        EXPECT_EQ(picture->height, 90u);
      } else {
        EXPECT_GT(picture->width, 160u);
      }
    }
    EXPECT_EQ(shaded, 1u);
    EXPECT_EQ(lights, 1u);
    const auto report = nlohmann::json::parse(read_file(json));
    EXPECT_EQ(report["suite"], "client");
    EXPECT_GT(report["rows"][0]["frames"].get<uint64_t>(), 0u);
    EXPECT_EQ(report["rows"][0]["wrong_frames"], 0);
    EXPECT_EQ(report["rows"][0]["mode"], mode);
  }
}

TEST(Client, FailuresAreOneClearLine) {
  const Daemon daemon;
  const TemporaryFolder folder;
  const auto fails = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments{"--pin", daemon.pin(), "--size", "160x90", "--frames", "1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto [status, output] = run("gnomon-client", arguments);
    EXPECT_EQ(status, 1) << output;
    EXPECT_EQ(std::count(output.begin(), output.end(), '\n'), 1) << output;
    return output;
  };
  const auto contains = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  const std::string server = daemon.server();
  EXPECT_TRUE(contains(fails({"--server", server, "--scene", "living_room", "--tenant", "nobody"}),
                       "refused (unknown_tenant)"));
  EXPECT_TRUE(contains(fails({"--server", server, "--scene", "attic"}), "no copy of scene 'attic'"));
  EXPECT_TRUE(contains(fails({"--server", server, "--scene", "living_room", "--mode", "psychic"}), "allowed are"));
  EXPECT_TRUE(contains(fails({"--server", "nowhere", "--scene", "living_room"}), "HOST:PORT"));
  // Another scene under the same name.
  fs::copy_file(living_room_file().parent_path() / "temple.glb", folder.path() / "living_room.glb");
  EXPECT_TRUE(contains(fails({"--server", server, "--tenant", "studio", "--scene", "living_room", "--scene-dir",
                              folder.path().string()}),
                       "is not the server's: content hash"));
}

}  // namespace
}  // namespace gnomon::tests
