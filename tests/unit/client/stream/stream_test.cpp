// Cameras out, masks in, against a scripted server.
#include <gtest/gtest.h>

#include "tests/unit/client/net/fake_server.h"
#include "tests/unit/client/stream/sliced.h"
#include "tests/unit/client/stream/watched.h"
#include "tests/unit/protocol/masks.h"

namespace gnomon::client {
namespace {

using namespace tests;
using namespace std::chrono_literals;

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
  EXPECT_EQ(watched.stream.counters().invalid_slices, 0u);
  watched.stream.close("");
}

TEST(Stream, GoesOverTheControlConnectionWhereDatagramsDoNotPass) {
  const auto mask = tests::noise(kGrid, 1);
  for (const Transport transport : {Transport::automatic, Transport::tcp}) {
    FakeServer server([&](Peer& peer) {
      peer.read();
      peer.welcome(tests::small_welcome(kWidth, kHeight, kLights));  // and answers no datagram
      const auto camera = peer.read_camera_by_control();
      if (camera) peer.send_frame_by_control(camera->frame, mask.view());
      peer.read();
    });
    auto options = options_for(server.address());
    options.connect.transport = transport;
    Watched watched(options);
    ASSERT_TRUE(watched.stream.wait_open());
    watched.stream.ask(camera_at(1));
    ASSERT_TRUE(watched.until([&] { return !watched.answers.empty(); }));
    EXPECT_TRUE(watched.answers[0].complete);
    EXPECT_EQ(watched.answers[0].words, mask.words);
    EXPECT_TRUE(watched.stream.connection().by_control());
    EXPECT_GT(watched.stream.connection().data_counters().received_bytes, 0u);
    watched.stream.close("");
  }
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
  EXPECT_GE(watched.stream.counters().invalid_slices, 2u);
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
  watched.stream.ask(camera_at(1));  // is not sent, and does no harm
}

// Once `news` has arrived, frames have the shape `grid`; the answer to an earlier camera still has the former one.
void expect_old_frames_left_behind(uint64_t features, const protocol::Message& news, const TileGrid& grid) {
  const auto mask = tests::noise(grid, 1);
  FakeServer server([&](Peer& peer) {
    peer.read();
    auto welcome = tests::small_welcome(kWidth, kHeight, kLights);
    welcome.features = features;
    peer.welcome(welcome);
    peer.read_new_camera();
    peer.write(news);
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
  EXPECT_EQ(watched.stream.grid(), grid);
  watched.stream.ask(camera_at(1));
  ASSERT_TRUE(watched.until([&] { return !watched.answers.empty(); }));
  EXPECT_EQ(watched.answers[0].frame, FrameId{2});
  EXPECT_EQ(watched.answers[0].words, mask.words);
  EXPECT_EQ(watched.stream.counters().invalid_slices, 0u);
  watched.stream.close("");
}

TEST(Stream, ASmallerSizeMidwayLeavesOldFramesBehind) {
  expect_old_frames_left_behind(
      0, protocol::Degraded{.width = kWidth / 2, .height = kHeight / 2, .rate_hz = 30, .reason = "load"},
      {kWidth / 2, kHeight / 2, kLights});
}

TEST(Stream, AnotherNumberOfLightsLeavesOldFramesBehindWhateverTheirSize) {
  expect_old_frames_left_behind(protocol::kFeatureSizes,
                                protocol::SceneChanged{tests::small_welcome(kWidth, kHeight, kLights + 1).scene},
                                {kWidth, kHeight, kLights + 1});
}

// Datagrams may overtake a message of the control connection, and arrive long after it.
TEST(Stream, SlicesThatSayTheirSizeAreNeverTakenForAnother) {
  const TileGrid half{kWidth / 2, kHeight / 2, kLights};
  const auto mask = tests::noise(half, 1);
  const auto send = [&mask](Peer& peer, FrameId frame) {
    auto encoded = tests::sliced(frame, mask.view(), 700);
    for (size_t i = 0; i < encoded.slices.size(); ++i) {
      encoded.slices[i].flags |= protocol::kSliceHasSize;
      encoded.slices[i].width = kWidth / 2;
      encoded.slices[i].height = kHeight / 2;
      peer.send_slice(encoded.slices[i], encoded.payload(i));
    }
  };
  FakeServer server([&](Peer& peer) {
    peer.read();
    auto welcome = tests::small_welcome(kWidth, kHeight, kLights);
    welcome.features = protocol::kFeatureSizes;
    peer.welcome(welcome);
    peer.read_new_camera();
    send(peer, FrameId{1});
    peer.read_new_camera();
    peer.write(protocol::Degraded{.width = kWidth / 2, .height = kHeight / 2, .rate_hz = 30, .reason = "load"});
    peer.read_new_camera();
    peer.send_frame(FrameId{2}, tests::noise(kGrid, 2).view());
    send(peer, FrameId{2});
    peer.read();
  });
  Watched watched(options_for(server.address()));
  ASSERT_TRUE(watched.stream.wait_open());
  watched.stream.ask(camera_at(0));
  ASSERT_TRUE(watched.until([&] { return watched.stream.counters().late_slices > 0; }))
      << "the new size, before the news";
  watched.stream.ask(camera_at(1));
  ASSERT_TRUE(watched.until([&] { return !watched.messages.empty(); }));
  watched.stream.ask(camera_at(2));
  ASSERT_TRUE(watched.until([&] { return !watched.answers.empty(); }));
  EXPECT_EQ(watched.answers[0].frame, FrameId{2}) << "asked for before the news, rendered after it";
  EXPECT_EQ(watched.answers[0].words, mask.words);
  EXPECT_EQ(watched.stream.counters().invalid_slices, 0u);
  watched.stream.close("");
}

}  // namespace
}  // namespace gnomon::client
