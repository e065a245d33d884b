// A stream to a scripted server, and the answers and messages that it has received.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "client/stream/visibility_stream.h"
#include "tests/unit/client/net/fake_server.h"

namespace gnomon::tests {

inline constexpr uint16_t kWidth = 160, kHeight = 96;
inline constexpr uint32_t kLights = 2;
inline constexpr TileGrid kGrid{kWidth, kHeight, kLights};

inline client::StreamOptions options_for(const client::Address& server) {
  client::StreamOptions options;
  options.connect.server = server;
  options.connect.trust = FakeServer::trust();
  options.connect.hello.scene = "little";
  options.connect.hello.width = kWidth;
  options.connect.hello.height = kHeight;
  options.patience = std::chrono::milliseconds(50);
  return options;
}

struct WatchedAnswer {
  FrameId frame;
  protocol::CameraView camera;
  std::vector<uint64_t> words;
  bool complete;
  size_t missing_tiles;
  LightPlanes planes;
};

struct Watched {
  client::Loop loop;
  std::vector<WatchedAnswer> answers;
  std::vector<protocol::Message> messages;
  client::VisibilityStream stream;

  explicit Watched(const client::StreamOptions& options)
      : stream(loop, options,
               {.answer =
                    [this](const client::Answer& a) {
                      answers.push_back({a.mask.frame, a.camera, a.mask.words, a.mask.complete(),
                                         a.mask.missing_tiles().size(), a.mask.planes});
                      EXPECT_GE(a.response, Nanoseconds{0});
                    },
                .message = [this](const protocol::Message& m) { messages.push_back(m); }}) {}

  template <class Done>
  bool until(Done done) {
    return loop.run_until(Clock::now() + std::chrono::seconds(10), done);
  }
};

inline protocol::CameraView camera_at(float x) {
  protocol::CameraView camera;
  camera.position = {x, 0, 0};
  return camera;
}

}  // namespace gnomon::tests
