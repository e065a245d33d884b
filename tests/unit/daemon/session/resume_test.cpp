// A session continues when its control connection is lost, and is resumed on another one.
#include "tests/unit/daemon/net/served.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

class Resume : public Served {
 protected:
  static protocol::Hello hello() {
    auto hello = TestClient::hello(kScene);
    hello.features = protocol::kFeatureResume;
    return hello;
  }
  bool answers(TestClient& client, uint32_t frame) {
    client.send_view(frame, static_cast<float>(frame));
    return is_frame_of(client, client.receive_frame(frame), static_cast<float>(frame));
  }
  // The number of open sessions; a session whose record rests does not count.
  bool sessions(int count) {
    return eventually([&] { return metrics_say("gnomon_sessions{tenant=\"default\"} " + std::to_string(count)); });
  }
};

TEST_F(Resume, FramesComeWithoutAControlConnectionAndWithTheNextOne) {
  start();
  TestClient first = client();
  ASSERT_TRUE(first.join(hello()));
  ASSERT_TRUE(first.welcome().features & protocol::kFeatureResume);
  EXPECT_TRUE(answers(first, 1));
  first.lose_control();
  EXPECT_TRUE(answers(first, 2));
  EXPECT_TRUE(answers(first, 3));
  TestClient second = client();
  ASSERT_TRUE(second.resume(first)) << second.refused().text;
  EXPECT_EQ(second.welcome().session, first.welcome().session);
  EXPECT_TRUE(answers(second, 4)) << "by the same keys";
  EXPECT_TRUE(sessions(1));
  TestClient third = client();
  ASSERT_TRUE(third.resume(second));
  EXPECT_FALSE(second.receive_a<protocol::Bye>()) << "the connection before is closed without a word";
  EXPECT_TRUE(answers(third, 5));
  EXPECT_TRUE(sessions(1));
}

TEST_F(Resume, WhatWasAskedForBeforeIsNotAnsweredTwice) {
  start();
  TestClient first = client();
  ASSERT_TRUE(first.join(hello()));
  EXPECT_TRUE(answers(first, 7));
  first.lose_control();
  TestClient second = client();
  ASSERT_TRUE(second.resume(first));
  second.send_view(7, 7);
  EXPECT_TRUE(answers(second, 8));
  EXPECT_TRUE(eventually([&] { return count_of(Fault::datagram_replayed) == 0; }));
}

// Nothing can be sent to the client meanwhile, although there are retransmissions to send.
TEST_F(Resume, AClientWithoutDatagramsHoldsNobodyUpWhileItIsAway) {
  start();
  TestClient away = client(), other = client();
  auto wants = hello();
  wants.features |= protocol::kFeatureFeedback;
  ASSERT_TRUE(away.join(wants));
  ASSERT_TRUE(other.join(hello()));
  away.send_view_by_control(1, 1);
  EXPECT_TRUE(is_frame_of(away, away.receive_frame_by_control(1), 1));
  away.send_view_by_control(2, 2);
  away.lose_control();
  for (uint32_t frame = 1; frame <= 60; ++frame) {
    ASSERT_TRUE(answers(other, frame));
    std::this_thread::sleep_for(10ms);
  }
  TestClient back = client();
  ASSERT_TRUE(back.resume(away));
  back.send_view_by_control(3, 3);
  EXPECT_TRUE(is_frame_of(back, back.receive_frame_by_control(3), 3));
}

TEST_F(Resume, WhoGivesUpTellsNobody) {
  start();
  TestClient first = client();
  ASSERT_TRUE(first.join(hello()));
  TestClient plain = client();
  ASSERT_TRUE(plain.join(TestClient::hello(kScene)));
  daemon_->give_up();
  EXPECT_FALSE(first.receive_a<protocol::Bye>());
  EXPECT_TRUE(plain.receive_a<protocol::Bye>());
  EXPECT_THROW(client(), std::system_error) << "nobody listens";
}

TEST_F(Resume, AnotherThreadMayGetTheConnection) {
  config_.server.net_threads = 3;
  start();
  auto before = std::make_unique<TestClient>(daemon_->control_port());
  ASSERT_TRUE(before->join(hello()));
  std::set<uint16_t> ports;
  for (uint32_t frame = 1; frame <= 6; ++frame) {
    EXPECT_TRUE(answers(*before, frame));
    auto next = std::make_unique<TestClient>(daemon_->control_port());
    ASSERT_TRUE(next->resume(*before)) << frame << ": " << next->refused().text;
    ports.insert(next->welcome().data_port);
    before = std::move(next);
  }
  EXPECT_EQ(ports.size(), 3u) << "each thread has a port of its own";
}

TEST_F(Resume, OnlyWhoKnowsTheSecretGetsTheSession) {
  start();
  TestClient honest = client(), other = client();
  ASSERT_TRUE(honest.join(hello()));
  ASSERT_TRUE(other.join(hello()));
  for (const bool own : {true, false}) {
    TestClient thief = client();
    protocol::Resume stolen{honest.welcome().session, own ? thief.proof_of(other) : other.proof_of(honest)};
    thief.send(stolen);  // the proof of another session, or of this one for another connection
    const auto refused = thief.receive_a<protocol::Refused>();
    ASSERT_TRUE(refused);
    EXPECT_EQ(refused->code, protocol::RefusalCode::unknown_session);
  }
  TestClient stranger = client();
  stranger.send(protocol::Resume{SessionId{1}, {}});
  const auto refused = stranger.receive_a<protocol::Refused>();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, protocol::RefusalCode::unknown_session) << "as if it had been wrong";
  EXPECT_EQ(count_of(Fault::refused_unknown_session), 3u);
  EXPECT_TRUE(answers(honest, 1));
}

TEST_F(Resume, ItsTimeEnds) {
  config_.server.silence_timeout = 300ms;
  start();
  TestClient first = client();
  ASSERT_TRUE(first.join(hello()));
  first.lose_control();
  for (uint32_t frame = 1; !metrics_say("gnomon_sessions{tenant=\"default\"} 0"); ++frame) {
    first.send_view(frame, 1);  // so that the session is not closed as silent
    std::this_thread::sleep_for(10ms);
    ASSERT_LT(frame, 2000u);
  }
  TestClient second = client();
  EXPECT_FALSE(second.resume(first));
  EXPECT_EQ(second.refused().code, protocol::RefusalCode::unknown_session);
}

TEST_F(Resume, WhoSaysByeOrCannotResumeIsGoneAtOnce) {
  start();
  TestClient polite = client();
  ASSERT_TRUE(polite.join(hello()));
  polite.send(protocol::Bye{"thanks"});
  EXPECT_TRUE(sessions(0));
  TestClient late = client();
  EXPECT_FALSE(late.resume(polite));
  TestClient plain = client();
  ASSERT_TRUE(plain.join(TestClient::hello(kScene)));
  EXPECT_FALSE(plain.welcome().features & protocol::kFeatureResume);
  EXPECT_TRUE(sessions(1));
  plain.lose_control();
  EXPECT_TRUE(sessions(0));
}

TEST_F(Resume, NotWhileDraining) {
  config_.server.drain_timeout = 2000ms;
  start();
  TestClient first = client();
  ASSERT_TRUE(first.join(hello()));
  TestClient second = client();
  std::thread drain([&] { daemon_->drain(); });
  EXPECT_TRUE(first.receive_a<protocol::Draining>());
  EXPECT_FALSE(second.resume(first));
  EXPECT_EQ(second.refused().code, protocol::RefusalCode::draining);
  first.send(protocol::Bye{});
  drain.join();
}

}  // namespace
}  // namespace gnomon::daemon
