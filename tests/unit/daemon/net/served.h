// A complete daemon in the test's process: real sockets on loopback, a fake renderer, scenes of one triangle.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "daemon/daemon.h"
#include "tests/unit/daemon/net/test_client.h"
#include "tests/unit/daemon/render/fake_renderer.h"

namespace gnomon::daemon {

// `of_light`: further members of the light's node, each with a comma behind it.
inline void write_scene(const std::filesystem::path& file, bool with_light, const std::string& of_light = "") {
  const std::string light =
      R"(, "extensionsUsed": ["KHR_lights_punctual"],
          "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point"}]}})";
  const std::string light_node = ", {" + of_light + R"("extensions": {"KHR_lights_punctual": {"light": 0}}})";
  std::ofstream(file) << R"({"asset": {"version": "2.0"},
    "buffers": [{"byteLength": 36, "uri":
      "data:application/octet-stream;base64,AACAvwAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                   "min": [-1, 0, 0], "max": [1, 1, 0]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "nodes": [{"mesh": 0})"
                      << (with_light ? light_node : "") << R"(], "scenes": [{"nodes": [0)"
                      << (with_light ? ", 1" : "") << R"(]}], "scene": 0)" << (with_light ? light : "") << "}";
}

class Served : public testing::Test {
 protected:
  static constexpr const char* kScene = "triangle";
  static constexpr uint32_t kLights = 1;

  void SetUp() override {
    std::string folder = (std::filesystem::temp_directory_path() / "gnomon_served_XXXXXX").string();
    ASSERT_NE(mkdtemp(folder.data()), nullptr);
    folder_ = folder;
    write_scene(folder_ / "triangle.gltf", true);
    std::filesystem::create_directory(folder_ / "files");
    write_scene(folder_ / "files" / "another.gltf", true);
    write_scene(folder_ / "files" / "dark.gltf", false);
    std::ofstream(folder_ / "files" / "broken.gltf") << "{";
    config_.server.mode = ServerMode::demo;
    config_.server.state_folder = folder_ / "state";
    config_.server.control_port = config_.server.data_port = config_.admin.port = 0;
    config_.admin.socket = folder_ / "admin.sock";
    config_.server.drain_timeout = std::chrono::milliseconds(0);
    config_.scenes.list = {{kScene, folder_ / "triangle.gltf", ""}};
    config_.scenes.allow_files = {folder_ / "files"};
    config_.render.passes = {"gbuffer", "trace", "pack", "readback"};
    config_.render.max_width = 640;
    config_.render.max_height = 480;
  }

  void TearDown() override {
    daemon_.reset();
    std::filesystem::remove_all(folder_);
  }

  void start() {
    auto daemon = try_start();
    ASSERT_TRUE(daemon) << daemon.error().message;
    daemon_ = std::move(*daemon);
  }

  Result<std::unique_ptr<Daemon>> try_start() {
    Daemon::Options options;
    options.config = config_;
    options.version = "test";
    options.on_stop = on_stop_;
    if (make_renderers_.empty()) {
      make_renderers_ = {[this]() -> Result<std::unique_ptr<gpu::Renderer>> {
        return std::unique_ptr<gpu::Renderer>(std::make_unique<SelfRunningFakeRenderer>(3, kLights, frame_time_));
      }};
    }
    options.make_renderers = make_renderers_;
    return Daemon::start(std::move(options));
  }

  TestClient client() { return TestClient(daemon_->control_port()); }

  uint64_t count_of(Fault fault) { return daemon_->metrics().count_of(fault); }

  // Waits for the condition; the limit only bounds a failing test.
  template <class Condition>
  bool eventually(Condition condition) {
    const TimePoint end = Clock::now() + kPatience;
    while (!condition()) {
      if (Clock::now() > end) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
  }

  bool metrics_say(const std::string& line) {
    return ("\n" + daemon_->metrics().text()).find("\n" + line + "\n") != std::string::npos;
  }

  // Whether the words are the fake renderer's answer for a camera at `x`; the buffer consists of complete tiles.
  static bool is_frame_of(const TestClient& client, const std::vector<uint64_t>& words, float x) {
    gpu::CameraView camera;
    camera.position.x = x;
    const TileGrid grid{client.welcome().width, client.welcome().height, kLights};
    if (words.size() != grid.word_count()) return false;
    for (size_t i = 0; i < words.size(); ++i) {
      if (words[i] != fake_word(camera, i)) return false;
    }
    return true;
  }

  std::filesystem::path folder_;
  Config config_;
  std::vector<RendererFactory> make_renderers_;  // if empty, one, which makes a SelfRunningFakeRenderer
  std::chrono::milliseconds frame_time_{0};
  std::function<void()> on_stop_;
  std::unique_ptr<Daemon> daemon_;
};

}  // namespace gnomon::daemon
