// Sessions over bad links: the real daemon, the real client library, netsim between them.
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "client/thin_client.h"
#include "tests/system/e2e/bad_link.h"
#include "tests/system/e2e/flier.h"
#include "tests/system/e2e/own_renderer.h"

namespace gnomon::tests {
namespace {

constexpr client::ViewSize kLarge{.width = 640, .height = 360};  // some datagrams a frame

// Lossy, not slow: a slow machine has its own queues.
TEST(Link, LostSlicesComeAgain) {
  Daemon daemon;
  Relay relay(daemon, {"--delay", "5ms", "--loss", "10%", "--seed", "3"});
  client::Loop loop;
  Fliers fliers;
  fliers.push_back(
      std::make_unique<Flier>(loop, daemon, "studio", living_room_path(), kSmall, "living_room", relay.address()));
  ASSERT_TRUE(all_progress(loop, fliers, 60)) << relay.process().output();
  ASSERT_TRUE(eventually([&] {
    loop.poll();
    return daemon.metric("gnomon_datagrams_lost_total") > 0;
  }));
  const client::StreamCounters& counters = fliers[0]->stream().counters();
  EXPECT_GE(counters.complete, 60u);
  EXPECT_GT(daemon.metric("gnomon_datagrams_retransmitted_total") + daemon.metric("gnomon_slices_recovered_total"),
            0);
  EXPECT_EQ(counters.invalid_slices, 0u);
}

TEST(Link, GoesByIPv6Too) {
  const int probe = socket(AF_INET6, SOCK_DGRAM, 0);
  sockaddr_in6 local{};
  local.sin6_family = AF_INET6;
  local.sin6_addr = in6addr_loopback;
  const bool has_ipv6 = probe >= 0 && bind(probe, reinterpret_cast<sockaddr*>(&local), sizeof local) == 0;
  if (probe >= 0) close(probe);
  if (!has_ipv6) GTEST_SKIP() << "this machine has no IPv6: nothing listens on ::1";
  std::string config = kConfig;
  config.replace(config.find("127.0.0.1"), 9, "'::1'");
  Daemon daemon(config);
  ASSERT_EQ(daemon.address().host, "::1");
  client::Loop loop;
  Fliers fliers;
  fliers.push_back(std::make_unique<Flier>(loop, daemon, "studio", living_room_path()));
  ASSERT_TRUE(all_progress(loop, fliers, 10));
  EXPECT_EQ(fliers[0]->stream().counters().invalid_slices, 0u);
}

TEST(Link, ANarrowOneIsFollowedNotFilled) {
  Daemon daemon;
  Relay relay(daemon, {"--delay", "5ms", "--rate", "1mbit", "--queue", "500ms"});
  client::Loop loop;
  Fliers fliers;
  fliers.push_back(
      std::make_unique<Flier>(loop, daemon, "studio", living_room_path(), kSmall, "living_room", relay.address()));
  ASSERT_TRUE(all_progress(loop, fliers, 40)) << relay.process().output();
  const std::string output = relay.end();
  EXPECT_NE(output.find(" 0 found the queue full"), std::string::npos) << output;
}

// What netsim says when it ends: the number before `what`.
uint64_t counted(const std::string& output, const std::string& what) {
  const size_t end = output.rfind(" " + what);
  if (end == std::string::npos) return 0;
  return std::stoull(output.substr(output.rfind(' ', end - 1) + 1));
}

// Datagrams vanish at the relay, and nobody says so.
// As where a client changes its network: its connection is gone, its session is not.
TEST(Link, AConnectionThatBreaksIsReplacedUnderItsSession) {
  const Daemon daemon;
  std::optional<Relay> relay(std::in_place, daemon, std::vector<std::string>{"--delay", "2ms"});
  client::Loop loop;
  Fliers fliers;
  fliers.push_back(
      std::make_unique<Flier>(loop, daemon, "studio", living_room_path(), kSmall, "living_room", relay->address()));
  const client::VisibilityStream& stream = fliers[0]->stream();
  ASSERT_TRUE(all_progress(loop, fliers, 5));
  const SessionId session = stream.connection().welcome().session;
  for (uint64_t broken = 1; broken <= 3; ++broken) {
    relay.reset();
    relay.emplace(daemon, std::vector<std::string>{"--delay", "2ms"});
    ASSERT_TRUE(loop.run_until(Clock::now() + kPatience, [&] { return stream.counters().resumed == broken; }))
        << stream.connection().failure().value_or(Error{"it still tries"}).message;
    ASSERT_TRUE(all_progress(loop, fliers, 5));
    EXPECT_EQ(stream.connection().welcome().session, session);
  }
  EXPECT_EQ(stream.counters().invalid_slices, 0u);
  EXPECT_EQ(daemon.sessions(), 1);
  EXPECT_EQ(daemon.metric("gnomon_refusals_total"), 0);
}

// What it shows goes with its masks' cameras, also those that were asked for while the connection was gone.
TEST(Link, AThinClientKnowsItsCamerasAfterItsConnectionWasReplaced) {
  const Daemon daemon;
  for (const client::Mode mode : {client::Mode::sequential, client::Mode::predicted}) {
    std::optional<Relay> relay(std::in_place, daemon, std::vector<std::string>{"--delay", "2ms"});
    client::Loop loop;
    client::ThinClientOptions options;
    options.mode = mode;
    options.stream.connect.server = relay->address();
    options.stream.connect.trust.pin = daemon.pin();
    options.stream.connect.timeout = kPatience;
    options.stream.connect.hello.tenant = "studio";
    options.stream.connect.hello.scene = "living_room";
    options.stream.connect.hello.width = kSmall.width;
    options.stream.connect.hello.height = kSmall.height;
    std::vector<protocol::CameraView> cameras;
    size_t received = 0, wrong = 0;
    client::ThinClient thin(loop, std::move(options), {.received = [&](const client::ReceivedMasks& masks) {
                              ++received;
                              wrong += !(masks.camera == cameras.at(masks.index));
                            }});
    ASSERT_TRUE(thin.wait_open());
    const client::CameraPath path = living_room_path();
    client::Timer pace(loop, [&] {
      if (mode != client::Mode::sequential || thin.in_flight() == 0) {
        cameras.push_back(client::view_of(path.at(0.1 * static_cast<double>(cameras.size())), kSmall));
        thin.look(cameras.back());
      }
      pace.arm(Clock::now() + std::chrono::milliseconds(50));
    });
    pace.arm(Clock::now());
    const auto gets = [&](size_t more) {
      const size_t wanted = received + more;
      return loop.run_until(Clock::now() + kPatience, [&] { return received >= wanted; });
    };
    for (uint64_t broken = 1; broken <= 2; ++broken) {
      ASSERT_TRUE(gets(10));
      relay.reset();
      relay.emplace(daemon, std::vector<std::string>{"--delay", "2ms"});
      ASSERT_TRUE(loop.run_until(Clock::now() + kPatience, [&] { return thin.counters().resumed == broken; }));
      ASSERT_TRUE(gets(10));
    }
    EXPECT_EQ(wrong, 0u);
    EXPECT_EQ(thin.reconnects(), 0u);
    EXPECT_EQ(thin.counters().invalid_slices, 0u);
  }
}

TEST(Link, WithoutDatagramsMasksComeOverTheControlConnection) {
  Daemon daemon;
  Relay relay(daemon, {"--udp-traffic", "off"});
  client::Loop loop;
  Fliers fliers;
  fliers.push_back(
      std::make_unique<Flier>(loop, daemon, "studio", living_room_path(), kSmall, "living_room", relay.address()));
  ASSERT_TRUE(all_progress(loop, fliers, 6)) << relay.process().output();
  EXPECT_TRUE(fliers[0]->stream().connection().by_control());
  EXPECT_EQ(fliers[0]->stream().counters().invalid_slices, 0u);
  OwnRenderer own(living_room_file());
  for (const FlierFrame& frame : fliers[0]->frames()) EXPECT_EQ(frame.words, own.render(frame.camera, kSmall));
  fliers[0]->land();
  const std::string output = relay.end();
  EXPECT_EQ(counted(output, "bytes"), 0u) << "no datagram got through: " << output;
  EXPECT_GT(counted(output, "blocked"), 0u) << output;
}

TEST(Link, DatagramsAreAsLongAsThePathTakes) {
  Daemon daemon;
  Relay relay(daemon, {"--mtu", "1300"});
  client::Loop loop;
  Fliers fliers;
  fliers.push_back(
      std::make_unique<Flier>(loop, daemon, "studio", living_room_path(), kLarge, "living_room", relay.address()));
  ASSERT_TRUE(all_progress(loop, fliers, 30)) << relay.process().output();
  EXPECT_EQ(fliers[0]->stream().counters().invalid_slices, 0u);
  EXPECT_EQ(fliers[0]->stream().counters().incomplete, 0u) << "longer ones were only tried";
  const std::string output = relay.end();
  EXPECT_EQ(counted(output, "bytes"), 1280u) << output;
  EXPECT_GT(counted(output, "blocked"), 0u) << output;
}

// The path changes under way: what is longer vanishes from then on.
TEST(Link, APathThatTakesShorterDatagramsThanBeforeIsFoundOut) {
  Daemon daemon;
  Relay relay(daemon, {"--mtu", "1472", "--at", "3s:mtu=1300"});
  const TimePoint narrow = Clock::now() + std::chrono::seconds(3);
  client::Loop loop;
  Fliers fliers;
  fliers.push_back(
      std::make_unique<Flier>(loop, daemon, "studio", living_room_path(), kLarge, "living_room", relay.address()));
  loop.run_until(narrow, [] { return false; });
  ASSERT_GT(fliers[0]->frames().size(), 0u);
  ASSERT_TRUE(all_progress(loop, fliers, 20)) << relay.process().output();
  EXPECT_FALSE(fliers[0]->stream().connection().by_control());
  EXPECT_EQ(fliers[0]->stream().counters().invalid_slices, 0u);
  const std::string output = relay.end();
  EXPECT_EQ(counted(output, "bytes"), 1472u) << "before: " << output;
}

}  // namespace
}  // namespace gnomon::tests
