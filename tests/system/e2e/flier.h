// An honest client within the test: asks for one camera after the other and counts its frames.
#pragma once

#include <memory>
#include <vector>

#include "client/media/camera_path.h"
#include "client/stream/visibility_stream.h"
#include "scenes/loader.h"
#include "tests/system/e2e/daemon.h"

namespace gnomon::tests {

constexpr client::ViewSize kSmall{.width = 160, .height = 90};

struct FlierFrame {
  protocol::CameraView camera;
  std::vector<uint64_t> words;
  protocol::Moment moment;
  std::vector<protocol::LightInfo> lights;
};

class Flier {
 public:
  Flier(client::Loop& loop, const Daemon& daemon, const std::string& tenant, const client::CameraPath& path,
        client::ViewSize size = kSmall, const std::string& scene = "living_room",
        const std::optional<client::Address>& by_way_of = {})
      : path_(path),
        size_(size),
        stream_(loop, options(daemon, by_way_of.value_or(daemon.address()), tenant, size, scene),
                {.answer =
                     [this](const client::Answer& answer) {
                       if (answer.mask.complete())
                         frames_.push_back({answer.camera, answer.mask.words, answer.mask.moment, answer.lights});
                       ask();
                     },
                 .opened = [this] { ask(); },
                 .message =
                     [this](const protocol::Message& message) {
                       draining_ = draining_ || std::holds_alternative<protocol::Draining>(message);
                     }}) {}

  const client::VisibilityStream& stream() const { return stream_; }
  const std::vector<FlierFrame>& frames() const { return frames_; }
  bool told_of_draining() const { return draining_; }
  void land() { stream_.close("landed"); }

 private:
  static client::StreamOptions options(const Daemon& daemon, const client::Address& server,
                                       const std::string& tenant, client::ViewSize size, const std::string& scene) {
    client::StreamOptions options;
    options.connect.server = server;
    options.connect.trust.pin = daemon.pin();
    options.connect.timeout = kPatience;
    options.connect.hello.tenant = tenant;
    options.connect.hello.scene = scene;
    options.connect.hello.width = static_cast<uint16_t>(size.traced_width());
    options.connect.hello.height = static_cast<uint16_t>(size.traced_height());
    return options;
  }

  void ask() {
    const double seconds = 0.37 * static_cast<double>(stream_.counters().asked);
    stream_.ask(client::view_of(path_.at(seconds), size_));
  }

  client::CameraPath path_;
  client::ViewSize size_;
  bool draining_ = false;
  std::vector<FlierFrame> frames_;
  client::VisibilityStream stream_;
};

using Fliers = std::vector<std::unique_ptr<Flier>>;

// Serves the loop until every flier has `more` further frames. False: patience ended first.
inline bool all_progress(client::Loop& loop, const Fliers& fliers, size_t more) {
  std::vector<size_t> wanted;
  for (const auto& flier : fliers) wanted.push_back(flier->frames().size() + more);
  return loop.run_until(Clock::now() + kPatience, [&] {
    for (size_t i = 0; i < fliers.size(); ++i) {
      if (fliers[i]->frames().size() < wanted[i]) return false;
    }
    return true;
  });
}

inline client::CameraPath living_room_path() {
  static const scenes::ScenePtr scene = scenes::load_scene(living_room_file()).value();
  return client::CameraPath::of_scene(scene);
}

}  // namespace gnomon::tests
