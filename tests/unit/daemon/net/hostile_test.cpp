// Hostile clients: none of what they do affects an honest one.
#include <random>

#include "tests/unit/daemon/net/served.h"

namespace gnomon::daemon {
namespace {

using protocol::RefusalCode;
using namespace std::chrono_literals;

class Hostile : public Served {
 protected:
  void SetUp() override {
    Served::SetUp();
    config_.server.handshake_timeout = 100ms;
  }
  void TearDown() override {
    honest_.reset();
    Served::TearDown();
  }

  // On a machine that is busy with other tests even an honest client may miss the short time for its Hello.
  void start_with_honest_client() {
    start();
    bool joined = false;
    for (int attempt = 0; attempt < 20 && !joined; ++attempt) {
      honest_ = std::make_unique<TestClient>(daemon_->control_port());
      joined = honest_->join(TestClient::hello(kScene));
    }
    ASSERT_TRUE(joined);
  }

  void expect_honest_client_is_served() {
    const uint32_t frame = next_frame_++;
    honest_->send_view(frame, static_cast<float>(frame));
    EXPECT_TRUE(is_frame_of(*honest_, honest_->receive_frame(frame), static_cast<float>(frame)));
  }

  std::unique_ptr<TestClient> honest_;
  uint32_t next_frame_ = 1;
};

TEST_F(Hostile, AHelloCutAnywhereTimesOutOrIsRefused) {
  start_with_honest_client();
  const std::vector<uint8_t> hello = protocol::encode(TestClient::hello(kScene));
  std::vector<std::unique_ptr<TestClient>> cut;
  for (size_t length = 0; length < hello.size(); ++length) {
    cut.push_back(std::make_unique<TestClient>(daemon_->control_port()));
    cut.back()->send_bytes({hello.begin(), hello.begin() + static_cast<ptrdiff_t>(length)});
  }
  for (auto& c : cut) EXPECT_FALSE(c->receive_a<protocol::Welcome>());
  EXPECT_EQ(count_of(Fault::handshake_timeout), hello.size());
  expect_honest_client_is_served();
}

TEST_F(Hostile, RandomControlBytesAreRefusedOrTimedOut) {
  start_with_honest_client();
  std::mt19937 random(5);
  for (int i = 0; i < 60; ++i) {
    std::vector<uint8_t> bytes(1 + random() % 400);
    for (uint8_t& b : bytes) b = static_cast<uint8_t>(random());
    TestClient c = client();
    c.send_bytes(bytes);
    EXPECT_FALSE(c.receive_a<protocol::Welcome>());
  }
  expect_honest_client_is_served();
}

TEST_F(Hostile, DamagedHellosNeverCrashTheServer) {
  start_with_honest_client();
  const std::vector<uint8_t> hello = protocol::encode(TestClient::hello(kScene));
  std::vector<std::unique_ptr<TestClient>> clients;
  for (size_t i = 0; i < hello.size(); ++i) {
    std::vector<uint8_t> damaged = hello;
    damaged[i] ^= 0xff;
    clients.push_back(std::make_unique<TestClient>(daemon_->control_port()));
    clients.back()->send_bytes(damaged);
  }
  for (auto& c : clients) (void)c->receive();
  expect_honest_client_is_served();
}

TEST_F(Hostile, AnAnnouncedGiantMessageIsRefusedAtOnce) {
  config_.server.handshake_timeout = 30s;  // long, so that the timeout does not end the connections
  start_with_honest_client();
  TestClient c = client();
  c.send_bytes({0xff, 0xff, 0xff, 0x7f, 1, 0});
  const auto refused = c.receive_a<protocol::Refused>();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, RefusalCode::malformed);
  expect_honest_client_is_served();
}

TEST_F(Hostile, MessagesOutOfTurnEndTheConnection) {
  start_with_honest_client();
  TestClient no_hello = client();
  no_hello.send(protocol::Draining{});
  const auto refused = no_hello.receive_a<protocol::Refused>();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, RefusalCode::malformed);

  TestClient twice = client();
  std::vector<uint8_t> both = protocol::encode(TestClient::hello(kScene));
  both.insert(both.end(), both.begin(), both.end());
  twice.send_bytes(both);
  std::optional<protocol::Message> last;
  while (auto message = twice.receive()) last = message;
  ASSERT_TRUE(last);
  EXPECT_TRUE(std::holds_alternative<protocol::Refused>(*last) || std::holds_alternative<protocol::Bye>(*last));

  TestClient pretender = client();
  ASSERT_TRUE(pretender.join(TestClient::hello(kScene)));
  pretender.send(protocol::Stats{});
  EXPECT_TRUE(pretender.receive_a<protocol::Bye>());
  EXPECT_TRUE(eventually([&] { return metrics_say("gnomon_sessions{tenant=\"default\"} 1"); }));
  expect_honest_client_is_served();
}

TEST_F(Hostile, HalfOpenConnectionsPushOutTheirOldestOnly) {
  config_.server.handshake_timeout = 30s;
  config_.server.max_half_open = 8;
  start_with_honest_client();
  std::vector<std::unique_ptr<TestClient>> idle;
  for (int i = 0; i < 40; ++i) idle.push_back(std::make_unique<TestClient>(daemon_->control_port()));
  EXPECT_TRUE(eventually([&] { return count_of(Fault::half_open_replaced) == 32; }));
  TestClient late = client();
  EXPECT_TRUE(late.join(TestClient::hello(kScene)));
  expect_honest_client_is_served();
}

TEST_F(Hostile, JunkDatagramsAreCountedByReasonAndAnsweredByNothing) {
  start_with_honest_client();
  TestClient victim = client();
  ASSERT_TRUE(victim.join(TestClient::hello(kScene)));
  const std::vector<uint8_t> valid = victim.sealed_view(1, 1);

  victim.send_datagram(std::vector<uint8_t>(protocol::kMaxDatagramBytes + 1, 7));
  victim.send_datagram({1, 2, 3});
  victim.send_datagram({});
  auto of_nobody = valid;
  of_nobody[4] ^= 0xff;  // the session's id
  victim.send_datagram(of_nobody);
  auto damaged = valid;
  damaged[protocol::kHeaderBytes] ^= 1;
  victim.send_datagram(damaged);
  EXPECT_TRUE(eventually([&] {
    return count_of(Fault::datagram_too_long) == 1 && count_of(Fault::datagram_header) == 2 &&
           count_of(Fault::datagram_session) == 1 && count_of(Fault::datagram_forged) == 1;
  })) << daemon_->metrics().text();

  victim.send_datagram(valid);
  EXPECT_FALSE(victim.receive_frame(1).empty()) << "nothing but the frame has come: junk is not answered";
  victim.send_datagram(valid);
  EXPECT_TRUE(eventually([&] { return count_of(Fault::datagram_replayed) == 1; }));
  expect_honest_client_is_served();
}

TEST_F(Hostile, DatagramsCutOrDamagedAtEveryByteHaveNoEffect) {
  start_with_honest_client();
  TestClient victim = client();
  ASSERT_TRUE(victim.join(TestClient::hello(kScene)));
  const std::vector<uint8_t> valid = victim.sealed_view(1, 1);
  for (size_t length = 0; length < valid.size(); ++length) {
    victim.send_datagram({valid.begin(), valid.begin() + static_cast<ptrdiff_t>(length)});
  }
  for (size_t i = 0; i < valid.size(); ++i) {
    auto damaged = valid;
    damaged[i] ^= 0x10;
    victim.send_datagram(damaged);
  }
  EXPECT_TRUE(eventually([&] {
    return count_of(Fault::datagram_header) + count_of(Fault::datagram_session) +
               count_of(Fault::datagram_replayed) + count_of(Fault::datagram_forged) ==
           2 * valid.size();
  }));
  EXPECT_FALSE(victim.receive_datagram(50ms)) << "a damaged datagram was answered";
  expect_honest_client_is_served();
}

TEST_F(Hostile, OldViewsDoNotReplaceNewOnesAndRepeatedOnesAreNoNews) {
  start_with_honest_client();
  const auto first = honest_->sealed_view(1, 1), second = honest_->sealed_view(2, 2),
             again = honest_->sealed_view(2, 2);
  next_frame_ = 3;
  honest_->send_datagram(second);
  EXPECT_TRUE(is_frame_of(*honest_, honest_->receive_frame(2), 2));
  honest_->send_datagram(first);
  honest_->send_datagram(again);
  EXPECT_TRUE(eventually([&] { return count_of(Fault::view_out_of_order) == 1; }));
  expect_honest_client_is_served();
  EXPECT_EQ(count_of(Fault::datagram_replayed), 0u);
}

TEST_F(Hostile, AnInventedArrivalEndsItsSessionAlone) {
  start_with_honest_client();
  for (const uint64_t number : {uint64_t{0}, uint64_t{1} << 40}) {
    TestClient liar = client();
    auto hello = TestClient::hello(kScene);
    hello.features |= protocol::kFeatureFeedback;
    ASSERT_TRUE(liar.join(hello));
    liar.send_view(1, 1);
    liar.send_feedback({.time_us = 1, .first = number, .count = 1, .ages = {1}});
    const auto bye = liar.receive_a<protocol::Bye>();
    ASSERT_TRUE(bye);
    EXPECT_NE(bye->reason.find("never sent"), std::string::npos) << bye->reason;
    liar.send_view(2, 2);
  }
  EXPECT_EQ(count_of(Fault::feedback_invented), 2u);
  EXPECT_TRUE(eventually([&] { return count_of(Fault::datagram_session) >= 2; }))
      << "what follows is of no session";
  expect_honest_client_is_served();
}

TEST_F(Hostile, AFloodOfFeedbackIsIgnoredBeyondItsAllowance) {
  start_with_honest_client();
  TestClient flooding = client();
  auto hello = TestClient::hello(kScene);
  hello.features |= protocol::kFeatureFeedback;
  ASSERT_TRUE(flooding.join(hello));
  for (int i = 0; i < 2000; ++i) {
    flooding.send_feedback({.time_us = static_cast<uint64_t>(-i), .count = protocol::kMaxReported});
    if (i % 100 == 0) expect_honest_client_is_served();
  }
  EXPECT_TRUE(eventually([&] { return count_of(Fault::feedback_too_often) > 0; }));
  flooding.send_view(1, 1);
  EXPECT_TRUE(is_frame_of(flooding, flooding.receive_frame(1), 1)) << "it is served on";
}

TEST_F(Hostile, AFloodOfViewsCostsAnHonestClientTurnsOfOneSessionOnly) {
  frame_time_ = 1ms;
  start_with_honest_client();
  TestClient flooding = client();
  ASSERT_TRUE(flooding.join(TestClient::hello(kScene)));
  uint32_t frame = 1;
  for (int round = 0; round < 20; ++round) {
    for (int i = 0; i < 50; ++i) flooding.send_view(frame++, 1);
    expect_honest_client_is_served();
  }
}

TEST_F(Hostile, AClientThatDoesNotReadItsControlConnectionIsRenderedNothingFurther) {
  start_with_honest_client();
  TestClient deaf = client();
  ASSERT_TRUE(deaf.join(TestClient::hello(kScene, 640, 480)));
  uint32_t frame = 1;
  const auto rendered = [&] { return daemon_->metrics().totals(TenantId{0}).buffers; };
  EXPECT_TRUE(eventually([&] {
    const double before = rendered();
    for (int i = 0; i < 20; ++i, ++frame) deaf.send_view_by_control(frame, static_cast<float>(frame));
    for (int i = 0; i < 3; ++i) expect_honest_client_is_served();
    return rendered() - before == 3;  // the honest client's
  }));
  for (int i = 0; i < 5; ++i) expect_honest_client_is_served();
  EXPECT_TRUE(metrics_say("gnomon_sessions{tenant=\"default\"} 2")) << "it is still there";
}

TEST_F(Hostile, AClientThatTakesNoFramesHoldsNobodyUp) {
  start_with_honest_client();
  TestClient deaf = client();
  ASSERT_TRUE(deaf.join(TestClient::hello(kScene, 640, 480)));
  for (uint32_t frame = 1; frame <= 200; ++frame) deaf.send_view(frame, static_cast<float>(frame));
  for (int i = 0; i < 5; ++i) expect_honest_client_is_served();
}

}  // namespace
}  // namespace gnomon::daemon
