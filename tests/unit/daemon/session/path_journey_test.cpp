// A session whose client proves its address, and moves, over simulated links in virtual time: what it costs.
#include <gtest/gtest.h>

#include <array>
#include <map>
#include <random>
#include <set>

#include "daemon/session/session.h"
#include "tests/tools/netsim/link.h"
#include "tests/unit/link/event_queue.h"
#include "tests/unit/link/made_frame.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;
using asio::ip::udp;
using protocol::DatagramKind;
using Bytes = std::vector<uint8_t>;

constexpr Nanoseconds kEvery = 16ms;  // between cameras
constexpr Nanoseconds kRender = 5ms;

udp::endpoint address(const char* host, uint16_t port = 1000) { return {asio::ip::make_address(host), port}; }

std::unique_ptr<protocol::Seal> seal(protocol::Side side) {
  return std::make_unique<protocol::Seal>(SessionId{1}, protocol::CipherId::aes_128_gcm, protocol::SealSecrets{},
                                          side);
}

// A client and the server's session, which sends what SessionLinks would.
class Journey {
 public:
  explicit Journey(Nanoseconds one_way, uint64_t features = protocol::kFeaturePaths)
      : up_({{.from = {}, .profile = {.delay = one_way}}}, 1, events_.now()),
        down_({{.from = {}, .profile = {.delay = one_way}}}, 2, events_.now()),
        session_(parts(features), events_.now()) {}

  // The first Ping and the cameras from now on.
  void fly() {
    client_sends(DatagramKind::ping, Bytes(protocol::kPingBytes));
    ask();
  }

  void ask() {
    protocol::CameraUpdate update;
    update.frame = FrameId{++frame_};
    Bytes body;
    protocol::append_camera_update(body, update);
    client_sends(DatagramKind::camera_update, body);
    events_.at(events_.now() + kEvery, [this] { ask(); });
  }

  // The client sends from there. `still_hears`: what comes to the address before reaches it too.
  void move_to(const udp::endpoint& address, bool still_hears) {
    if (!still_hears) hears_.clear();
    address_ = address;
    hears_.insert(address);
  }

  void run(Nanoseconds time) { events_.run_until(events_.now() + time); }

  Session& session() { return session_; }
  TimePoint now() const { return events_.now(); }

  struct Address {
    size_t from = 0, to = 0;             // bytes
    TimePoint first_from{}, first_to{};  // the first datagram, and the first slice sent there
    TimePoint first_arrived{};           // slice
  };
  std::map<udp::endpoint, Address> addresses;
  std::vector<TimePoint> slices_arrived;
  bool answers = true;  // challenges

 private:
  SessionParts parts(uint64_t features) {
    auto permit = limits_.take(TenantId{0}, ClientNetwork{});
    return {.id = SessionId{1},
            .grant = {.features = features},
            .seal = seal(protocol::Side::server),
            .permit = std::get<SessionPermit>(std::move(permit)),
            .random = [engine = std::mt19937_64(9)]() mutable { return engine(); }};
  }

  void client_sends(DatagramKind kind, const Bytes& body) {
    Bytes datagram;
    client_->seal(kind, body, datagram);
    Address& here = addresses[address_];
    here.from += datagram.size();
    if (here.first_from == TimePoint{}) here.first_from = events_.now();
    const auto fate = up_.send_datagram(datagram.size(), events_.now());
    for (const TimePoint at : fate.arrivals()) {
      events_.at(at, [this, datagram, from = address_] { server_receives(datagram, from); });
    }
  }

  void server_receives(const Bytes& datagram, const udp::endpoint& from) {
    const DatagramOutcome received = session_.receive(datagram, from, events_.now());
    if (received.ping) {
      server_sends(DatagramKind::pong, Bytes(protocol::kPingBytes), from);
      session_.path().sent(from, protocol::kMaxDatagramBytes);
    }
    if (received.view) render(*received.view);
    serve();
  }

  void render(const ViewRequest& view) {
    ++rendered;
    events_.at(events_.now() + kRender, [this, frame = view.frame] {
      session_.link().add(frame_of(frame.value, 5), TimePoint::max(), events_.now());
      serve();
    });
  }

  void serve() {
    const TimePoint now = events_.now();
    while (const auto challenge = session_.path().challenge_due(now)) {
      Bytes body;
      protocol::append_path_token(body, challenge->token);
      server_sends(DatagramKind::path_challenge, body, challenge->to);
    }
    failures += session_.path().take_failure(now);
    if (const auto& to = session_.path().current()) {
      while (const auto out = session_.link().next(now))
        server_sends(out->kind, Bytes(out->body.begin(), out->body.end()), *to);
      if (const auto view = session_.views().take(now)) render(*view);
    }
    const TimePoint wake = session_.path().wake_at();
    if (wake != TimePoint::max()) events_.at(wake, [this] { serve(); });
  }

  void server_sends(DatagramKind kind, const Bytes& body, const udp::endpoint& to) {
    Bytes datagram;
    const uint64_t sequence = session_.seal().seal(kind, body, datagram);
    session_.link().sent(sequence, datagram.size(), events_.now());
    Address& there = addresses[to];
    there.to += datagram.size();
    if (kind == DatagramKind::frame_slice && there.first_to == TimePoint{}) there.first_to = events_.now();
    const auto fate = down_.send_datagram(datagram.size(), events_.now());
    for (const TimePoint at : fate.arrivals())
      events_.at(at, [this, datagram, to] { client_receives(datagram, to); });
  }

  void client_receives(const Bytes& datagram, const udp::endpoint& at) {
    if (!hears_.contains(at)) return;
    const auto opened = client_->open(datagram);
    if (!opened) return;
    if (opened->header.kind == DatagramKind::frame_slice) {
      slices_arrived.push_back(events_.now());
      if (addresses[at].first_arrived == TimePoint{}) addresses[at].first_arrived = events_.now();
    }
    if (opened->header.kind == DatagramKind::path_challenge && answers) {
      client_sends(DatagramKind::path_response, Bytes(opened->body.begin(), opened->body.end()));
    }
  }

  tests::EventQueue events_;
  netsim::Link up_, down_;
  SessionLimits limits_{Config{}};
  Session session_;
  std::unique_ptr<protocol::Seal> client_ = seal(protocol::Side::client);
  udp::endpoint address_ = address("192.0.2.1");
  std::set<udp::endpoint> hears_{address_};
  uint32_t frame_ = 0;

 public:
  size_t failures = 0;  // addresses that were given up
  size_t rendered = 0;  // frames
};

Nanoseconds longest_gap(const std::vector<TimePoint>& times) {
  Nanoseconds longest{};
  for (size_t i = 1; i < times.size(); ++i) longest = std::max(longest, times[i] - times[i - 1]);
  return longest;
}

class PathJourney : public testing::TestWithParam<std::chrono::milliseconds> {};

TEST_P(PathJourney, TheStartCostsARoundTripLessTheFirstFramesRendering) {
  const Nanoseconds one_way = GetParam(), round_trip = 2 * one_way;
  std::array<Nanoseconds, 2> first{};
  for (const bool proves : {false, true}) {
    Journey journey(one_way, proves ? protocol::kFeaturePaths : 0);
    const TimePoint welcomed = journey.now();
    journey.fly();
    journey.run(1s);
    ASSERT_FALSE(journey.slices_arrived.empty());
    first[proves] = journey.slices_arrived.front() - welcomed;
    EXPECT_LE(longest_gap(journey.slices_arrived), std::max(kEvery, round_trip)) << "and it flies on";
  }
  EXPECT_EQ(first[1] - first[0], std::max<Nanoseconds>(0ms, round_trip - kRender));
}

// The mapping of a NAT changes: what goes to the address before is lost.
TEST_P(PathJourney, ANewPortIsServedOneAndAHalfRoundTripsAfterItsFirstDatagram) {
  Journey journey(GetParam());
  journey.fly();
  journey.run(1s);
  const auto rebound = address("192.0.2.1", 2000);
  journey.move_to(rebound, false);
  journey.run(2s);
  const Journey::Address& there = journey.addresses[rebound];
  ASSERT_NE(there.first_to, TimePoint{});
  EXPECT_LE(there.first_to - there.first_from, 3 * GetParam() + kEvery) << "waits for the next frame at most";
  EXPECT_EQ(journey.session().path().current(), rebound);
  EXPECT_LE(longest_gap(journey.slices_arrived), 4 * GetParam() + 2 * kEvery);
  EXPECT_EQ(journey.failures, 0u);
}

// The client has both interfaces for a while: nothing is missed.
TEST_P(PathJourney, AnotherInterfaceTakesOverWithoutAGap) {
  Journey journey(GetParam());
  journey.fly();
  journey.run(1s);
  const Nanoseconds before = longest_gap({journey.slices_arrived.end() - 20, journey.slices_arrived.end()});
  const size_t arrived = journey.slices_arrived.size();
  const auto other = address("198.51.100.1");
  journey.move_to(other, true);
  journey.run(2s);
  EXPECT_EQ(journey.session().path().current(), other);
  EXPECT_NE(journey.addresses[other].first_arrived, TimePoint{});
  EXPECT_LE(longest_gap({journey.slices_arrived.begin() + static_cast<ptrdiff_t>(arrived) - 1,
                         journey.slices_arrived.end()}),
            before);
}

// Somebody with a session of their own, who sends from an address that is not theirs.
TEST_P(PathJourney, AVictimGetsAtMostThreeTimesWhatWasSentInItsName) {
  Journey journey(GetParam());
  journey.answers = false;
  journey.fly();
  journey.run(20s);
  const auto victim = address("192.0.2.1");
  EXPECT_LE(journey.addresses[victim].to, 3 * journey.addresses[victim].from);
  EXPECT_TRUE(journey.slices_arrived.empty());
  EXPECT_GT(journey.failures, 5u);
  EXPECT_EQ(journey.rendered, 1u) << "the first, while its address might have been proved";

  Journey turns(GetParam());
  turns.fly();
  turns.run(1s);
  turns.answers = false;
  const auto other = address("203.0.113.9");
  turns.move_to(other, true);
  turns.run(20s);
  EXPECT_LE(turns.addresses[other].to, 3 * turns.addresses[other].from);
  EXPECT_EQ(turns.addresses[other].first_to, TimePoint{});
  EXPECT_EQ(turns.session().path().current(), address("192.0.2.1")) << "which is served on";
}

INSTANTIATE_TEST_SUITE_P(OneWay, PathJourney, testing::Values(1ms, 10ms, 50ms, 90ms));

}  // namespace
}  // namespace gnomon::daemon
