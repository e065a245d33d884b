// What arrives is what the renderer makes of that camera, bit for bit; and the reference client makes pictures of it.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "client/media/png.h"
#include "client/view/client_renderer.h"
#include "gpu/vulkan_renderer.h"
#include "gpu/wire/translate.h"
#include "tests/system/e2e/daemon.h"
#include "tests/system/e2e/flier.h"
#include "tests/system/e2e/own_renderer.h"
#include "tests/unit/gpu/surface_probe.h"

namespace gnomon::tests {
namespace {

namespace fs = std::filesystem;

TEST(Exact, ReceivedMasksAreTheRenderersBitForBit) {
  const Daemon daemon;
  OwnRenderer own(living_room_file());
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
      EXPECT_EQ(frame.words, own.render(frame.camera, size));
      for (const uint64_t word : frame.words) ++(word ? lit : dark);
    }
    EXPECT_GT(lit, 0u);
    EXPECT_GT(dark, 0u);
  }
}

// A frame whose masks are its own, shown by the client, is the picture that tracing here would give.
TEST(Exact, AFreshFrameIsTheLocalPicturePixelForPixel) {
  const Daemon daemon;
  const auto scene = scenes::load_scene(living_room_file());
  ASSERT_TRUE(scene);
  gpu::RendererOptions local;
  local.device = "cpu";
  auto probe = gpu::SurfaceProbe::create(local, *scene);
  ASSERT_TRUE(probe) << probe.error().message;
  const client::ViewSize size{.width = 150, .height = 82, .border_x = 32, .border_y = 18};
  auto view = client::ClientRenderer::create(*scene, size, {.device = "cpu"});
  ASSERT_TRUE(view) << view.error().message;

  client::Loop loop;
  Fliers fliers;
  fliers.push_back(std::make_unique<Flier>(loop, daemon, "studio", living_room_path(), size));
  ASSERT_TRUE(all_progress(loop, fliers, 4));
  fliers[0]->land();
  uint32_t index = 0;
  for (const auto& frame : fliers[0]->frames()) {
    const auto picture_of = [&](const std::vector<uint64_t>& words) {
      auto received = std::make_shared<client::ReceivedMasks>();
      received->index = ++index;
      received->camera = frame.camera;
      received->mask.grid = {size.traced_width(), size.traced_height(),
                             static_cast<uint32_t>((*scene)->lights.size())};
      received->mask.words = words;
      return view->shade({.index = index, .camera = frame.camera, .seen = received});
    };
    const auto traced = probe->render(gpu::from_wire(frame.camera), size.traced_width(), size.traced_height(), {});
    ASSERT_TRUE(traced) << traced.error().message;
    const auto received = picture_of(frame.words), made_here = picture_of(traced->words);
    ASSERT_TRUE(received && made_here);
    EXPECT_TRUE(*received == *made_here);
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
  for (const std::string mode : {"sequential", "non-sequential", "queued", "predicted", "auto"}) {
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
    EXPECT_EQ(report["rows"][0]["invalid_slices"], 0);
    EXPECT_EQ(report["rows"][0]["mode"], mode);
    EXPECT_GT(report["rows"][0]["shown"].get<uint64_t>(), 0u);
    EXPECT_GT(report["rows"][0]["response_p50_ms"].get<double>(), 0);
  }
}

// Frames of a video, as ffmpeg reads it: one byte of brightness for each pixel.
std::string brightness(const fs::path& video) {
  const fs::path raw = video.string() + ".raw";
  const std::string command =
      "ffmpeg -loglevel error -y -i '" + video.string() + "' -f rawvideo -pix_fmt gray '" + raw.string() + "'";
  return std::system(command.c_str()) == 0 ? read_file(raw) : "";
}

// Beside what this machine traces itself; and what masks of the frame's own camera show differs from it nowhere.
TEST(Client, RecordsWhatItShows) {
  if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) GTEST_SKIP() << "there is no program ffmpeg";
  const Daemon daemon;
  const TemporaryFolder folder;
  constexpr size_t kFrames = 3;
  const auto record = [&](const std::string& view) {
    const fs::path video = folder.path() / (view + ".mp4");
    const auto [status, output] =
        run("gnomon-client", {"--server", daemon.server(), "--pin", daemon.pin(), "--tenant", "studio", "--scene",
                              "living_room", "--size", "160x90", "--border", "32x18", "--frames",
                              std::to_string(kFrames), "--record", video.string(), "--record-view", view});
    EXPECT_EQ(status, 0) << output;
    return brightness(video);
  };
  const std::string shown = record("shown"), both = record("side-by-side"), difference = record("difference");
  ASSERT_EQ(shown.size(), kFrames * 160 * 90);
  ASSERT_EQ(both.size(), kFrames * (160 + 4 + 160) * 90);
  ASSERT_EQ(difference.size(), kFrames * 160 * 90);
  const auto brightest = [](const std::string& frames) {
    return *std::max_element(frames.begin(), frames.end(),
                             [](char a, char b) { return static_cast<uint8_t>(a) < static_cast<uint8_t>(b); });
  };
  EXPECT_GT(static_cast<uint8_t>(brightest(shown)), 100);
  EXPECT_EQ(static_cast<uint8_t>(brightest(difference)), 0);
}

// Ctrl-C at a terminal reaches every program of the group, ffmpeg too if it were in it.
TEST(Client, AnInterruptedRecordingKeepsItsFramesAndFigures) {
  if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) GTEST_SKIP() << "there is no program ffmpeg";
  const Daemon daemon;
  const TemporaryFolder folder;
  const fs::path video = folder.path() / "flight.mp4", json = folder.path() / "flight.json",
                 said = folder.path() / "said";
  // The client leads a group of its own, which gets the signal when the video has been begun.
  const std::string client = "setsid '" GNOMON_CLIENT "' --server " + daemon.server() + " --pin " + daemon.pin() +
                             " --tenant studio --scene living_room --size 160x90 --frames 100000 --record '" +
                             video.string() + "' --json '" + json.string() + "' >'" + said.string() + "' 2>&1";
  const std::string command = client + " & pid=$!; until [ -e '" + video.string() +
                              "' ] || ! kill -0 $pid; do sleep 0.1; done; sleep 3; kill -INT -$pid; wait $pid";
  EXPECT_EQ(std::system(command.c_str()), 0) << read_file(said);
  EXPECT_NE(read_file(said).find("interrupted"), std::string::npos);
  const auto row = nlohmann::json::parse(read_file(json))["rows"][0];
  EXPECT_EQ(row["interrupted"], true);
  const size_t shown = row["shown"].get<size_t>();
  EXPECT_GT(shown, 0u);
  EXPECT_EQ(brightness(video).size(), shown * 160 * 90) << "a frame of video for each picture shown";
}

TEST(Client, FailuresAreOneClearLine) {
  const Daemon daemon;
  const TemporaryFolder folder;
  constexpr int kWrongUsage = 2;
  const auto fails = [&](std::vector<std::string> more, int expected = 1) {
    std::vector<std::string> arguments{"--pin", daemon.pin(), "--size", "160x90", "--frames", "1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto [status, output] = run("gnomon-client", arguments);
    EXPECT_EQ(status, expected) << output;
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
  EXPECT_TRUE(contains(fails({"--server", server, "--scene", "living_room", "--mode", "psychic"}, kWrongUsage),
                       "allowed are"));
  EXPECT_TRUE(contains(fails({"--server", "nowhere", "--scene", "living_room"}, kWrongUsage), "HOST:PORT"));
  // Another scene under the same name.
  fs::copy_file(living_room_file().parent_path() / "temple.glb", folder.path() / "living_room.glb");
  EXPECT_TRUE(contains(fails({"--server", server, "--tenant", "studio", "--scene", "living_room", "--scene-dir",
                              folder.path().string()}),
                       "is not the server's: content hash"));
}

}  // namespace
}  // namespace gnomon::tests
