// The complete client against a scripted server: what it shows, and that it reconnects.
#include "client/thin_client.h"

#include <gtest/gtest.h>

#include "tests/unit/client/net/fake_server.h"
#include "tests/unit/client/stream/watched.h"
#include "tests/unit/protocol/masks.h"

namespace gnomon::client {
namespace {

using namespace tests;
using namespace std::chrono_literals;

ThinClientOptions options_for(const Address& server, Mode mode, size_t ahead) {
  ThinClientOptions options;
  options.stream = tests::options_for(server);
  options.mode = mode;
  options.ahead = ahead;
  return options;
}

TEST(ThinClient, ShowsCamerasAheadOfTheirMasks) {
  const auto mask = tests::noise(kGrid, 1);
  FakeServer server([&](Peer& peer) {
    peer.read();
    peer.welcome(tests::small_welcome(kWidth, kHeight, kLights));
    const auto camera = peer.read_new_camera();  // answers only the first one
    if (camera) peer.send_frame(camera->frame, mask.view());
    peer.read();
  });
  Loop loop;
  size_t received = 0;
  ThinClient client(loop, options_for(server.address(), Mode::predicted, 2),
                    {.received = [&](const ReceivedMasks&) { ++received; }});
  ASSERT_TRUE(client.wait_open());
  EXPECT_FALSE(client.next());
  client.look(camera_at(0));
  ASSERT_TRUE(loop.run_until(Clock::now() + 10s, [&] { return received == 1; }));
  const auto fresh = client.next();
  ASSERT_TRUE(fresh);
  EXPECT_FALSE(fresh->reprojected);
  EXPECT_EQ(fresh->camera, camera_at(0));
  EXPECT_EQ(fresh->seen->mask.words, mask.words);
  for (int i = 1; i < 5; ++i) {
    client.look(camera_at(static_cast<float>(i)));
    const auto showing = client.next();
    ASSERT_EQ(showing.has_value(), i <= 2) << i;
    if (!showing) continue;
    EXPECT_TRUE(showing->reprojected);
    EXPECT_EQ(showing->camera, camera_at(static_cast<float>(i)));
    EXPECT_EQ(showing->seen->camera, camera_at(0));
    EXPECT_EQ(showing->ahead(), static_cast<size_t>(i));
    EXPECT_GE(showing->age, Nanoseconds{0});
  }
  client.close("");
}

TEST(ThinClient, StaysOutWhereItIsToldTo) {
  for (const uint32_t stay_out_ms : {0u, 61'500u}) {
    FakeServer server(
        [&](Peer& peer) {
          peer.read();
          peer.welcome(tests::small_welcome(kWidth, kHeight, kLights));
          peer.write(protocol::Bye{"too loud", stay_out_ms});
          peer.hang_up();
        },
        stay_out_ms > 0 ? 1 : 2);
    Loop loop;
    std::vector<std::string> lost;
    ThinClient client(loop, options_for(server.address(), Mode::queued, 0),
                      {.lost = [&](const Error& why) { lost.push_back(why.message); }});
    ASSERT_TRUE(client.wait_open());
    ASSERT_TRUE(loop.run_until(Clock::now() + 20s, [&] { return client.failure() || client.reconnects() > 0; }));
    if (stay_out_ms == 0) {
      EXPECT_FALSE(client.failure()) << "it comes back";
      EXPECT_EQ(lost.front(), "the server ended the session: too loud");
    } else {
      ASSERT_TRUE(client.failure());
      EXPECT_EQ(client.failure()->message,
                "the server ended the session: too loud; it keeps this client out for 62 s");
      EXPECT_TRUE(lost.empty()) << "it is not looked for";
      ASSERT_TRUE(client.refusal());
      EXPECT_EQ(client.refusal()->code, protocol::RefusalCode::kept_out);
    }
    client.close("");
  }
}

TEST(ThinClient, FindsItsServerAgain) {
  const auto mask = tests::noise(kGrid, 1);
  FakeServer server(
      [&](Peer& peer) {
        peer.read();
        peer.welcome(tests::small_welcome(kWidth, kHeight, kLights));
        const auto camera = peer.read_new_camera();
        if (camera) peer.send_frame(camera->frame, mask.view());
        peer.read();  // a message, or nothing for a while, before it hangs up
        peer.hang_up();
      },
      2);
  Loop loop;
  std::vector<uint32_t> received;
  ThinClient client(loop, options_for(server.address(), Mode::queued, 0),
                    {.received = [&](const ReceivedMasks& r) { received.push_back(r.index); }});
  ASSERT_TRUE(client.wait_open());
  for (const size_t connection : {0u, 1u}) {
    ASSERT_TRUE(loop.run_until(Clock::now() + 20s, [&] { return client.online(); })) << connection;
    client.look(camera_at(static_cast<float>(connection)));
    ASSERT_TRUE(loop.run_until(Clock::now() + 20s, [&] { return received.size() > connection; })) << connection;
    ASSERT_TRUE(loop.run_until(Clock::now() + 20s, [&] { return !client.online(); })) << connection;
  }
  EXPECT_EQ(received, (std::vector<uint32_t>{0, 1})) << "cameras keep their count over connections";
  EXPECT_EQ(client.reconnects(), 1u);
  EXPECT_EQ(client.counters().complete, 2u);
  const auto showing = client.next();
  ASSERT_TRUE(showing);
  EXPECT_EQ(showing->index, 1u) << "what has come stays";
  client.close("");
}

// It is told that its token was revoked, and then finds that it is a stranger.
TEST(ThinClient, ARefusalDoesNotHideWhyTheSessionBeforeWasEnded) {
  int connections = 0;
  FakeServer server(
      [&](Peer& peer) {
        peer.read();
        if (connections++ > 0)
          return peer.write(protocol::Refused{protocol::RefusalCode::bad_token, "the token is not that of it"});
        peer.welcome(tests::small_welcome(kWidth, kHeight, kLights));
        peer.write(protocol::Bye{"its token was revoked"});
        peer.hang_up();
      },
      2);
  Loop loop;
  ThinClient client(loop, options_for(server.address(), Mode::queued, 0));
  ASSERT_TRUE(client.wait_open());
  ASSERT_TRUE(loop.run_until(Clock::now() + 20s, [&] { return client.failure().has_value(); }));
  EXPECT_EQ(
      client.failure()->message,
      "the server ended the session: its token was revoked; and a new one: refused (bad_token): the token is not "
      "that of it");
}

TEST(ThinClient, ARefusalIsFinal) {
  FakeServer server([&](Peer& peer) {
    peer.read();
    peer.write(protocol::Refused{protocol::RefusalCode::unknown_scene, "no such scene"});
  });
  Loop loop;
  ThinClient client(loop, options_for(server.address(), Mode::predicted, 2));
  const auto opened = client.wait_open();
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().message.find("unknown_scene"), std::string::npos);
  EXPECT_TRUE(client.failure());
}

}  // namespace
}  // namespace gnomon::client
