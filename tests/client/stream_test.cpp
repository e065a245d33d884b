// Connection and stream against a server that plays a script.
#include <gtest/gtest.h>

#include "client/visibility_stream.h"
#include "tests/client/fake_server.h"
#include "tests/client/sliced.h"
#include "tests/protocol/masks.h"

namespace gnomon::client {
namespace {

using namespace std::chrono_literals;
using tests::FakeServer;
using tests::Peer;

constexpr uint16_t kWidth = 160, kHeight = 96;
constexpr uint32_t kLights = 2;
constexpr TileGrid kGrid{kWidth, kHeight, kLights};

StreamOptions options_for(const Address& server) {
  StreamOptions options;
  options.connect.server = server;
  options.connect.hello.scene = "little";
  options.connect.hello.width = kWidth;
  options.connect.hello.height = kHeight;
  options.patience = 50ms;
  return options;
}

struct Received {
  FrameId frame;
  protocol::CameraView camera;
  std::vector<uint64_t> words;
  bool complete;
  size_t missing_tiles;
};

// A stream, and what came of it.
struct Watched {
  Loop loop;
  std::vector<Received> answers;
  std::vector<protocol::Message> messages;
  VisibilityStream stream;

  explicit Watched(const StreamOptions& options)
      : stream(loop, options,
               {.answer =
                    [this](const Answer& a) {
                      answers.push_back(
                          {a.mask.frame, a.camera, a.mask.words, a.mask.complete(), a.mask.missing_tiles().size()});
                      EXPECT_GE(a.response, Nanoseconds{0});
                    },
                .message = [this](const protocol::Message& m) { messages.push_back(m); }}) {}

  template <class Done>
  bool until(Done done) {
    return loop.run_until(Clock::now() + 10s, done);
  }
};

protocol::CameraView camera_at(float x) {
  protocol::CameraView camera;
  camera.position = {x, 0, 0};
  return camera;
}

TEST(Connection, SaysHelloAndIsWelcomed) {
  std::optional<protocol::Message> hello, bye;
  {
    FakeServer server([&](Peer& peer) {
      hello = peer.read();
      peer.welcome(tests::small_welcome(kWidth, kHeight, kLights));
      bye = peer.read();
    });
    auto options = options_for(server.address());
    options.connect.hello.tenant = "museum";
    options.connect.hello.token = "secret";
    Watched watched(options);
    const auto opened = watched.stream.wait_open();
    ASSERT_TRUE(opened) << opened.error().message;
    EXPECT_EQ(watched.stream.grid(), kGrid);
    EXPECT_EQ(watched.stream.scene().name, "little");
    EXPECT_EQ(watched.stream.connection().state(), Connection::State::open);
    watched.stream.close("seen enough");
    EXPECT_EQ(watched.stream.connection().state(), Connection::State::closed);
    EXPECT_FALSE(watched.stream.connection().failure()) << "closing on purpose is no failure";
  }
  ASSERT_TRUE(hello && bye);
  EXPECT_EQ(std::get<protocol::Hello>(*hello).tenant, "museum");
  EXPECT_EQ(std::get<protocol::Hello>(*hello).token, "secret");
  EXPECT_EQ(std::get<protocol::Bye>(*bye).reason, "seen enough");
}

TEST(Connection, ARefusalSaysWhyAndWhatWouldFit) {
  FakeServer server([](Peer& peer) {
    peer.read();
    peer.write(protocol::Refused{protocol::RefusalCode::over_capacity, "the device is full", 1280, 720, 30});
  });
  Watched watched(options_for(server.address()));
  const auto opened = watched.stream.wait_open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().message, "refused (over_capacity): the device is full; would fit: 1280x720 at 30 Hz");
  ASSERT_TRUE(watched.stream.connection().refusal());
  EXPECT_EQ(watched.stream.connection().refusal()->code, protocol::RefusalCode::over_capacity);
}

TEST(Connection, NobodyListeningIsOneClearLine) {
  Address address;
  {
    FakeServer server([](Peer& peer) { peer.hang_up(); });
    address = server.address();
    Watched first(options_for(address));
    EXPECT_FALSE(first.stream.wait_open());
  }
  Watched watched(options_for(address));
  const auto opened = watched.stream.wait_open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().message.rfind("cannot reach " + to_string(address) + ": ", 0), 0u)
      << opened.error().message;
}

TEST(Connection, MalformedBytesCloseWithAReason) {
  FakeServer server([](Peer& peer) {
    peer.read();
    peer.write_bytes(std::vector<uint8_t>(4096, 0xff));
    peer.read();
  });
  Watched watched(options_for(server.address()));
  const auto opened = watched.stream.wait_open();
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().message.find("malformed"), std::string::npos) << opened.error().message;
}

TEST(Connection, AnEndBeforeWelcomeIsAnError) {
  FakeServer server([](Peer& peer) { peer.read(); });
  Watched watched(options_for(server.address()));
  const auto opened = watched.stream.wait_open();
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().message.find("closed the connection"), std::string::npos);
}

TEST(Connection, ASilentServerIsGivenUp) {
  FakeServer server([](Peer& peer) {
    peer.read();
    peer.read();  // the client's closing
  });
  auto options = options_for(server.address());
  options.connect.timeout = 100ms;
  Watched watched(options);
  const auto opened = watched.stream.wait_open();
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().message.find("no answer from 127.0.0.1:"), std::string::npos);
}

TEST(Connection, AWelcomeLargerThanAskedForIsRefused) {
  FakeServer server([](Peer& peer) {
    peer.read();
    peer.welcome(tests::small_welcome(kWidth, kHeight + 1, kLights));
    peer.read();
  });
  Watched watched(options_for(server.address()));
  EXPECT_FALSE(watched.stream.wait_open());
}

TEST(Stream, AnswersBelongToTheirCameras) {
  std::vector<tests::Mask> masks;
  for (uint32_t i = 0; i < 5; ++i) masks.push_back(tests::noise(kGrid, i));
  FakeServer server([&](Peer& peer) {
    peer.read();
    peer.welcome(tests::small_welcome(kWidth, kHeight, kLights));
    for (const auto& mask : masks) {
      const auto camera = peer.read_new_camera();
      if (camera) peer.send_frame(camera->frame, mask.view());
    }
    peer.read();
  });
  Watched watched(options_for(server.address()));
  ASSERT_TRUE(watched.stream.wait_open());
  for (size_t i = 0; i < masks.size(); ++i) {
    EXPECT_EQ(watched.stream.ask(camera_at(static_cast<float>(i))).value, i + 1);
    ASSERT_TRUE(watched.until([&] { return watched.answers.size() > i; }));
    EXPECT_TRUE(watched.answers[i].complete);
    EXPECT_EQ(watched.answers[i].words, masks[i].words);
    EXPECT_EQ(watched.answers[i].camera, camera_at(static_cast<float>(i)));
    EXPECT_EQ(watched.stream.in_flight(), 0u);
  }
  EXPECT_EQ(watched.stream.counters().complete, 5u);
  EXPECT_EQ(watched.stream.counters().wrong_frames, 0u);
  watched.stream.close("");
}

TEST(Stream, CamerasAcknowledgeWhatHasArrived) {
  const auto mask = tests::noise(kGrid, 1);
  std::optional<protocol::CameraUpdate> first, second;
  {
    FakeServer server([&](Peer& peer) {
      peer.read();
      peer.welcome(tests::small_welcome(kWidth, kHeight, kLights));
      first = peer.read_new_camera();
      if (first) peer.send_frame(first->frame, mask.view());
      second = peer.read_new_camera();
    });
    Watched watched(options_for(server.address()));
    ASSERT_TRUE(watched.stream.wait_open());
    watched.stream.ask(camera_at(0));
    ASSERT_TRUE(watched.until([&] { return !watched.answers.empty(); }));
    watched.stream.ask(camera_at(1));
  }
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->ack_count, 0);
  ASSERT_EQ(second->ack_count, 1);
  EXPECT_EQ(second->acks[0].frame, first->frame);
  EXPECT_NE(second->acks[0].slices & 1, 0u);
}

TEST(Stream, TheNewestCameraIsRepeatedUntilAnsweredAndAnsweredOnce) {
  const auto mask = tests::noise(kGrid, 1);
  std::vector<uint32_t> seen;
  {
    FakeServer server([&](Peer& peer) {
      peer.read();
      peer.welcome(tests::small_welcome(kWidth, kHeight, kLights));
      for (int i = 0; i < 3; ++i) {
        if (const auto camera = peer.read_camera()) seen.push_back(camera->frame.value);
      }
      peer.send_frame(FrameId{1}, mask.view());
      peer.read();
    });
    Watched watched(options_for(server.address()));
    ASSERT_TRUE(watched.stream.wait_open());
    watched.stream.ask(camera_at(3));
    ASSERT_TRUE(watched.until([&] { return !watched.answers.empty(); }));
    EXPECT_EQ(watched.stream.counters().asked, 1u);
    EXPECT_EQ(watched.stream.counters().complete, 1u);
    watched.stream.close("");
  }
  EXPECT_EQ(seen, (std::vector<uint32_t>{1, 1, 1}));
}

TEST(Stream, ALostSliceIsHandedOverAsMissingTiles) {
  const auto mask = tests::noise(kGrid, 1);
  FakeServer server([&](Peer& peer) {
    peer.read();
    peer.welcome(tests::small_welcome(kWidth, kHeight, kLights));
    const auto camera = peer.read_new_camera();
    if (!camera) return;
    const auto encoded = tests::sliced(camera->frame, mask.view(), 600);
    for (size_t i = 0; i + 1 < encoded.slices.size(); ++i) {
      peer.send_slice(encoded.slices[i], encoded.payload(i));
    }
    peer.read();
  });
  Watched watched(options_for(server.address()));
  ASSERT_TRUE(watched.stream.wait_open());
  watched.stream.ask(camera_at(0));
  ASSERT_TRUE(watched.until([&] { return !watched.answers.empty(); }));
  EXPECT_FALSE(watched.answers[0].complete);
  EXPECT_GT(watched.answers[0].missing_tiles, 0u);
  EXPECT_EQ(watched.stream.counters().lost_slices, 1u);
  EXPECT_EQ(watched.stream.counters().incomplete, 1u);
  watched.stream.close("");
}

TEST(Stream, WhatWasNotAskedForIsCountedAndNotDelivered) {
  const auto mask = tests::noise(kGrid, 1);
  FakeServer server([&](Peer& peer) {
    peer.read();
    peer.welcome(tests::small_welcome(kWidth, kHeight, kLights));
    const auto camera = peer.read_new_camera();
    if (!camera) return;
    peer.send_raw(std::vector<uint8_t>(300, 0xaa));
    peer.send_frame(FrameId{0}, mask.view());
    peer.send_frame(FrameId{camera->frame.value + 1000}, mask.view());
    peer.send_frame(camera->frame, mask.view());
    peer.send_frame(camera->frame, mask.view());
    peer.write(protocol::Stats{.frames = 1});
    peer.read();
  });
  Watched watched(options_for(server.address()));
  ASSERT_TRUE(watched.stream.wait_open());
  watched.stream.ask(camera_at(0));
  ASSERT_TRUE(watched.until([&] { return watched.stream.counters().late_slices > 0; }));
  EXPECT_EQ(watched.answers.size(), 1u) << "the first answer once";
  EXPECT_GE(watched.stream.counters().wrong_frames, 2u);
  EXPECT_EQ(watched.stream.connection().data_counters().rejected, 1u);
  ASSERT_TRUE(watched.until([&] { return !watched.messages.empty(); }));
  EXPECT_EQ(std::get<protocol::Stats>(watched.messages[0]).frames, 1u);
  watched.stream.close("");
}

TEST(Stream, SkippedCamerasAreCountedOnceTheyExpire) {
  const auto mask = tests::noise(kGrid, 1);
  FakeServer server([&](Peer& peer) {
    peer.read();
    peer.welcome(tests::small_welcome(kWidth, kHeight, kLights));
    std::optional<protocol::CameraUpdate> camera;
    for (int i = 0; i < 3; ++i) camera = peer.read_new_camera();
    if (camera) peer.send_frame(camera->frame, mask.view());
    peer.read();
  });
  auto options = options_for(server.address());
  options.answer_timeout = 200ms;
  Watched watched(options);
  ASSERT_TRUE(watched.stream.wait_open());
  for (int i = 0; i < 3; ++i) watched.stream.ask(camera_at(0));
  ASSERT_TRUE(watched.until([&] { return !watched.answers.empty(); }));
  EXPECT_EQ(watched.answers[0].frame, FrameId{3});
  EXPECT_EQ(watched.stream.in_flight(), 0u) << "older cameras are not waited for";
  watched.stream.ask(camera_at(0));
  ASSERT_TRUE(watched.until([&] { return watched.stream.counters().unanswered == 1; }));
  EXPECT_EQ(watched.stream.counters().superseded, 2u);
  watched.stream.close("");
}

TEST(Stream, AServerThatVanishesIsReportedAndSurvived) {
  FakeServer server([](Peer& peer) {
    peer.read();
    peer.welcome(tests::small_welcome(kWidth, kHeight, kLights));
    peer.read_new_camera();
    peer.hang_up();
  });
  Watched watched(options_for(server.address()));
  ASSERT_TRUE(watched.stream.wait_open());
  watched.stream.ask(camera_at(0));
  ASSERT_TRUE(watched.until([&] { return watched.stream.connection().failure().has_value(); }));
  EXPECT_NE(watched.stream.connection().failure()->message.find("closed the connection"), std::string::npos);
  watched.stream.ask(camera_at(1));  // goes nowhere, harms nothing
}

TEST(Stream, ASmallerSizeMidwayLeavesOldFramesBehind) {
  const TileGrid half{kWidth / 2, kHeight / 2, kLights};
  const auto mask = tests::noise(half, 1);
  FakeServer server([&](Peer& peer) {
    peer.read();
    peer.welcome(tests::small_welcome(kWidth, kHeight, kLights));
    peer.read_new_camera();
    peer.write(protocol::Degraded{.width = kWidth / 2, .height = kHeight / 2, .rate_hz = 30, .reason = "load"});
    const auto camera = peer.read_new_camera();
    if (!camera) return;
    peer.send_frame(FrameId{1}, tests::noise(kGrid, 2).view());
    peer.send_frame(camera->frame, mask.view());
    peer.read();
  });
  Watched watched(options_for(server.address()));
  ASSERT_TRUE(watched.stream.wait_open());
  watched.stream.ask(camera_at(0));
  ASSERT_TRUE(watched.until([&] { return !watched.messages.empty(); }));
  EXPECT_EQ(watched.stream.grid(), half);
  watched.stream.ask(camera_at(1));
  ASSERT_TRUE(watched.until([&] { return !watched.answers.empty(); }));
  EXPECT_EQ(watched.answers[0].frame, FrameId{2});
  EXPECT_EQ(watched.answers[0].words, mask.words);
  EXPECT_EQ(watched.stream.counters().wrong_frames, 0u);
  watched.stream.close("");
}

}  // namespace
}  // namespace gnomon::client
