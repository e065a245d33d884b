// A session's policy, with a clock that the test advances.
#include "daemon/session/session.h"

#include <gtest/gtest.h>

#include "daemon/session/session_table.h"
#include "protocol/feedback.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;
using asio::ip::udp;

class SessionTest : public testing::Test {
 protected:
  static constexpr TimePoint kStart = TimePoint(1h);

  Session& add(uint64_t id, TimePoint now, uint64_t features = 0) {
    auto permit = limits_.take(TenantId{0}, ClientNetwork{});
    return table_.add(std::make_unique<Session>(SessionParts{.id = SessionId{id},
                                                             .grant = {.features = features},
                                                             .seal = this->seal(id, protocol::Side::server),
                                                             .permit = std::get<SessionPermit>(std::move(permit))},
                                                now));
  }

  static std::unique_ptr<protocol::Seal> seal(uint64_t id, protocol::Side side) {
    return std::make_unique<protocol::Seal>(SessionId{id}, protocol::CipherId::aes_128_gcm, protocol::SealSecrets{},
                                            side);
  }

  // The next datagram of that session's client.
  std::vector<uint8_t> view(uint64_t id, uint32_t frame) {
    auto& client = client_seals_[id];
    if (!client) client = seal(id, protocol::Side::client);
    protocol::CameraUpdate update;
    update.frame = FrameId{frame};
    std::vector<uint8_t> body, datagram;
    protocol::append_camera_update(body, update);
    client->seal(protocol::DatagramKind::camera_update, body, datagram);
    return datagram;
  }

  udp::endpoint here_{asio::ip::address_v4::loopback(), 1000};
  udp::endpoint there_{asio::ip::address_v4::loopback(), 2000};
  SessionLimits limits_{Config{}};
  SessionTable table_;
  std::map<uint64_t, std::unique_ptr<protocol::Seal>> client_seals_;
};

TEST_F(SessionTest, SilentOnesAreFoundBySilenceAlone) {
  add(1, kStart);
  Session& talking = add(2, kStart);
  EXPECT_TRUE(table_.silent_since(kStart + 5s - 5s).empty());
  talking.receive(view(2, 1), here_, kStart + 3s);
  EXPECT_EQ(table_.silent_since(kStart + 5001ms - 5s), std::vector<SessionId>{SessionId{1}});
  EXPECT_EQ(table_.silent_since(kStart + 8001ms - 5s).size(), 2u);
}

TEST_F(SessionTest, OnlyWhatIsAuthenticCountsAsLifeAndMovesTheAddress) {
  Session& session = add(1, kStart);
  EXPECT_FALSE(session.path().current());
  auto damaged = view(1, 1);
  damaged.back() ^= 1;
  EXPECT_EQ(session.receive(damaged, there_, kStart + 3s).fault, Fault::datagram_forged);
  EXPECT_FALSE(session.path().current());
  EXPECT_EQ(session.last_received(), kStart);
  EXPECT_TRUE(session.receive(view(1, 2), here_, kStart + 4s).view);
  EXPECT_EQ(session.path().current(), here_);
  EXPECT_TRUE(session.receive(view(1, 3), there_, kStart + 5s).view);
  EXPECT_EQ(session.path().current(), there_);
  EXPECT_EQ(session.last_received(), kStart + 5s);
}

TEST_F(SessionTest, RepeatedFramesAreLifeButNoNewsAndOldOnesAreDropped) {
  Session& session = add(1, kStart);
  EXPECT_TRUE(session.receive(view(1, 5), here_, kStart).view);
  const DatagramOutcome repeated = session.receive(view(1, 5), here_, kStart + 1s);
  EXPECT_FALSE(repeated.view);
  EXPECT_FALSE(repeated.fault);
  EXPECT_EQ(session.last_received(), kStart + 1s);
  EXPECT_EQ(session.receive(view(1, 4), here_, kStart).fault, Fault::view_out_of_order);
}

TEST_F(SessionTest, FramesGoTheWayOfTheNewestView) {
  Session& session = add(1, kStart, protocol::kFeaturePaths);
  const auto data = [](uint32_t frame) {
    protocol::CameraUpdate update;
    update.frame = FrameId{frame};
    protocol::Data made;
    protocol::append_camera_update(made.body, update);
    return made;
  };
  EXPECT_TRUE(session.receive(data(1), kStart).view);
  EXPECT_EQ(session.way(), Way::control);
  EXPECT_TRUE(session.receive(data(2), kStart, Way::web_transport).view);
  EXPECT_EQ(session.way(), Way::web_transport);
  EXPECT_TRUE(session.receive(data(4), kStart).view);
  EXPECT_EQ(session.receive(data(3), kStart, Way::web_transport).fault, Fault::view_out_of_order);
  EXPECT_EQ(session.way(), Way::control) << "what was overtaken says nothing";
  session.receive(data(4), kStart, Way::web_transport);
  EXPECT_EQ(session.way(), Way::web_transport) << "a sign of life does";
}

TEST_F(SessionTest, FrameNumbersMayWrap) {
  Session& session = add(1, kStart);
  EXPECT_TRUE(session.receive(view(1, 0xfffffffe), here_, kStart).view);
  EXPECT_TRUE(session.receive(view(1, 2), here_, kStart).view);
  EXPECT_EQ(session.receive(view(1, 0xffffffff), here_, kStart).fault, Fault::view_out_of_order);
}

TEST_F(SessionTest, AServersOwnKindOfDatagramIsRefused) {
  Session& session = add(1, kStart);
  const auto client = seal(1, protocol::Side::client);
  std::vector<uint8_t> datagram;
  client->seal(protocol::DatagramKind::frame_slice, {}, datagram);
  EXPECT_EQ(session.receive(datagram, here_, kStart).fault, Fault::datagram_kind);
  client->seal(protocol::DatagramKind::camera_update, {}, datagram);
  EXPECT_EQ(session.receive(datagram, here_, kStart).fault, Fault::datagram_body);
  EXPECT_FALSE(session.path().current());
}

TEST_F(SessionTest, FeedbackWithoutTheFeatureIsNotRead) {
  Session& session = add(1, kStart);
  const auto client = seal(1, protocol::Side::client);
  std::vector<uint8_t> body, datagram;
  protocol::append_feedback(body, {.first = 7, .count = 1, .ages = {1}});
  client->seal(protocol::DatagramKind::feedback, body, datagram);
  const DatagramOutcome received = session.receive(datagram, here_, kStart);
  EXPECT_EQ(received.fault, Fault::datagram_kind);
  EXPECT_FALSE(received.ends_session());
}

TEST_F(SessionTest, LeavesOutNumbersAndDisbelievesWhoReportsThem) {
  Session& session = add(1, kStart, protocol::kFeatureFeedback);
  std::vector<uint64_t> used;
  std::vector<uint8_t> datagram;
  while (used.empty() || used.back() == used.size()) {
    session.omit_number();
    used.push_back(session.seal().seal(protocol::DatagramKind::probe, {}, datagram));
    session.link().sent(used.back(), datagram.size(), kStart);
    ASSERT_LE(used.size(), OmittedNumbers::kLongestRun);
  }
  const auto client = seal(1, protocol::Side::client);
  const auto report = [&](uint64_t number) {
    std::vector<uint8_t> body, sealed;
    protocol::append_feedback(body, {.first = number, .count = 1, .ages = {1}});
    client->seal(protocol::DatagramKind::feedback, body, sealed);
    return session.receive(sealed, here_, kStart);
  };
  EXPECT_FALSE(report(used.back()).ends_session());
  EXPECT_TRUE(report(used.back() - 1).ends_session());
}

// Slices of `bytes` each.
protocol::EncodedMask large_frame(uint32_t frame, uint16_t slices, size_t bytes) {
  protocol::EncodedMask made;
  made.offsets.push_back(0);
  for (uint16_t i = 0; i < slices; ++i) {
    protocol::SliceHeader header;
    header.frame = FrameId{frame};
    header.slice = i;
    header.slice_count = slices;
    header.tile_count = header.light_count = 1;
    made.slices.push_back(header);
    made.bytes.resize(made.bytes.size() + bytes);
    made.offsets.push_back(made.bytes.size());
  }
  return made;
}

TEST_F(SessionTest, AViewWaitsForTheLinkAndANewerOneTakesItsPlace) {
  Session& session = add(1, kStart, protocol::kFeatureFeedback);
  ASSERT_TRUE(session.receive(view(1, 1), here_, kStart).view);
  FrameMeta meta;
  meta.route.frame = FrameId{1};
  session.under_way().add(meta, session.link().add(large_frame(1, 200, 1100), TimePoint::max(), kStart));
  EXPECT_FALSE(session.receive(view(1, 2), here_, kStart + 1ms).view);
  EXPECT_FALSE(session.receive(view(1, 3), here_, kStart + 2ms).view);
  EXPECT_FALSE(session.views().take(kStart + 2ms));
  const TimePoint later = session.views().take_at(kStart + 2ms);
  ASSERT_GT(later, kStart + 100ms);

  TimePoint now = kStart;
  for (uint64_t sent = 0; session.link().wake_at(now) < kStart + 10s && sent < 200; now += 1ms) {
    while (session.link().next(now)) session.link().sent(++sent, 1168, now);
  }
  const auto ended = session.under_way().take_ended();
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->meta.route.frame, FrameId{1});
  EXPECT_TRUE(ended->complete);
  const auto kept = session.views().take(now);
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->frame, FrameId{3});
  EXPECT_EQ(kept->coalesced, 1u);
  EXPECT_FALSE(session.views().take(now)) << "once";
}

TEST_F(SessionTest, FramesWhoseDeadlineIsOverEndAndAreNotWhole) {
  Session& session = add(1, kStart, protocol::kFeatureFeedback);
  session.receive(view(1, 1), here_, kStart);
  FrameMeta meta;
  meta.route.frame = FrameId{1};
  session.under_way().add(meta, session.link().add(large_frame(1, 200, 1100), kStart + 20ms, kStart));
  EXPECT_FALSE(session.under_way().take_ended());
  EXPECT_FALSE(session.link().next(kStart + 20ms));
  const auto ended = session.under_way().take_ended();
  ASSERT_TRUE(ended);
  EXPECT_FALSE(ended->complete);
}

TEST_F(SessionTest, StatsAreTotalsAndMeansOfTheInterval) {
  Session& session = add(1, kStart);
  FrameMeta meta;
  meta.times.arrival = kStart;
  meta.times.submitted = kStart + 2ms;
  meta.times.gpu = 3ms;
  meta.coalesced = 4;
  session.totals().add(meta, kStart + 10ms);
  meta.times.submitted = kStart + 4ms;
  meta.coalesced = 0;
  session.totals().add(meta, kStart + 20ms);
  EXPECT_EQ(session.totals().take_stats(), (protocol::Stats{2, 4, 3000, 3000, 15000}));
  EXPECT_EQ(session.totals().take_stats(), (protocol::Stats{2, 4, 0, 0, 0}));
}

TEST_F(SessionTest, ClosingASessionGivesItsPermitBack) {
  add(1, kStart);
  add(2, kStart);
  EXPECT_EQ(limits_.taken(), 2u);
  table_.remove(SessionId{1});
  EXPECT_EQ(limits_.taken(), 1u);
}

protocol::MaskReferencePtr sent_frame(uint32_t frame, uint32_t width = 8) {
  const TileGrid grid{width, 8, 1};
  const std::vector<uint64_t> words(grid.word_count(), frame);
  return std::make_shared<protocol::MaskReference>(FrameId{frame}, TileMaskView{grid, words});
}

TEST(SessionReferences, AreWhatTheClientSaysThatItHas) {
  const TileGrid grid{8, 8, 1};
  SessionReferences references;
  for (uint32_t frame = 1; frame <= 4; ++frame) references.sent(sent_frame(frame), {});
  EXPECT_EQ(references.newest(grid, {}), nullptr);
  references.client_has(FrameId{2});
  ASSERT_NE(references.newest(grid, {}), nullptr);
  EXPECT_EQ(references.newest(grid, {})->frame(), FrameId{2});
  EXPECT_EQ(references.newest({16, 8, 1}, {}), nullptr) << "another shape";
  references.client_has(FrameId{1});
  EXPECT_EQ(references.newest(grid, {}), nullptr) << "given up when it had a newer one";
  references.client_has(FrameId{4});
  EXPECT_EQ(references.newest(grid, {})->frame(), FrameId{4});
  references.client_has(FrameId{0});
  EXPECT_EQ(references.newest(grid, {}), nullptr);
}

// Of as many planes, which the client tells apart all the same.
TEST(SessionReferences, AreOfTheSamplesInForce) {
  const TileGrid grid{8, 8, 1};
  const SampleCounts full{1, Occlusion::full}, half{1, Occlusion::half};
  SessionReferences references;
  references.sent(sent_frame(1), full);
  references.client_has(FrameId{1});
  EXPECT_NE(references.newest(grid, full), nullptr);
  EXPECT_EQ(references.newest(grid, half), nullptr);
}

TEST(SessionReferences, AreNotReferredToForEver) {
  const TileGrid grid{8, 8, 1};
  SessionReferences references;
  references.sent(sent_frame(1), {});
  references.client_has(FrameId{1});
  uint32_t frame = 1;
  while (references.newest(grid, {})) references.sent(sent_frame(++frame), {});
  EXPECT_LT(frame, protocol::ReferenceShelf::kFrames) << "the client would have given it up by then";
  EXPECT_GT(frame, protocol::ReferenceShelf::kFrames / 2);
}

}  // namespace
}  // namespace gnomon::daemon
