// To which addresses a whole daemon sends: clients with real sockets that prove theirs, or do not.
#include "tests/unit/daemon/net/served.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;
using protocol::DatagramKind;

class Paths : public Served {
 protected:
  // A socket somewhere else on this machine, which says nothing unless it is told to.
  class Stranger {
   public:
    explicit Stranger(uint16_t data_port)
        : socket_(io_, {asio::ip::address_v4({127, 0, 0, 77}), 0}),
          server_(asio::ip::address_v4::loopback(), data_port) {
      socket_.non_blocking(true);
    }
    void send(const std::vector<uint8_t>& datagram) {
      socket_.send_to(asio::buffer(datagram), server_);
      sent_ += datagram.size();
    }
    // Everything that has come so far.
    void listen() {
      std::array<uint8_t, 9000> datagram;
      asio::error_code none;
      for (size_t size; size = socket_.receive(asio::buffer(datagram), 0, none), !none;) {
        received_ += size;
        ++kinds_[datagram[1]];
      }
    }
    size_t sent() const { return sent_; }
    size_t received() const { return received_; }
    size_t count_of(DatagramKind kind) { return kinds_[static_cast<size_t>(kind)]; }

   private:
    asio::io_context io_;
    asio::ip::udp::socket socket_;
    asio::ip::udp::endpoint server_;
    size_t sent_ = 0, received_ = 0;
    std::array<size_t, 256> kinds_{};
  };

  void expect_served(TestClient& client, uint32_t frame) {
    client.send_view(frame, static_cast<float>(frame));
    EXPECT_TRUE(is_frame_of(client, client.receive_frame(frame), static_cast<float>(frame))) << frame;
  }
};

TEST_F(Paths, AClientWithoutTheFeatureIsRefusedByDefault) {
  start();
  TestClient old = client();
  auto hello = TestClient::hello(kScene);
  hello.features = protocol::kFeatureFeedback;
  old.send(hello);
  const auto refused = old.receive_a<protocol::Refused>();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, protocol::RefusalCode::version);
  EXPECT_NE(refused->text.find("paths"), std::string::npos) << refused->text;
}

TEST_F(Paths, AClientWithoutTheFeatureIsServedWhereItIsNotRequired) {
  config_.server.require_path_validation = false;
  start();
  TestClient old = client(), other = client();
  auto hello = TestClient::hello(kScene);
  hello.features = 0;
  ASSERT_TRUE(old.join(hello, false));
  EXPECT_EQ(old.welcome().features & protocol::kFeaturePaths, 0u);
  expect_served(old, 1);
  old.change_data_port();
  expect_served(old, 2);
  ASSERT_TRUE(other.join(hello)) << "who has the feature proves its address here too";
  expect_served(other, 1);
}

TEST_F(Paths, TheFirstFrameIsRenderedMeanwhileAndGoesOutOnceTheAddressIsProved) {
  start();
  TestClient c = client();
  auto hello = TestClient::hello(kScene);
  ASSERT_TRUE(c.join(hello, false));
  ASSERT_EQ(c.welcome().features & protocol::kFeaturePaths, protocol::kFeaturePaths);
  c.send_view(1, 1);
  c.send_view(2, 2);
  const auto challenge = c.receive_opened();
  ASSERT_TRUE(challenge);
  ASSERT_EQ(challenge->header.kind, DatagramKind::path_challenge);
  const std::vector<uint8_t> token(challenge->body.begin(), challenge->body.end());
  EXPECT_FALSE(c.receive_datagram(50ms)) << "slices wait";
  c.send_datagram(c.sealed(DatagramKind::path_response, token));
  EXPECT_TRUE(is_frame_of(c, c.receive_frame(1), 1));
  EXPECT_TRUE(is_frame_of(c, c.receive_frame(2), 2)) << "the newest of those that waited";
}

TEST_F(Paths, ASilentAddressGetsAtMostThreeTimesTheBytesThatItSent) {
  start();
  TestClient owner = client();
  ASSERT_TRUE(owner.join(TestClient::hello(kScene, 640, 480), false));
  Stranger victim(owner.welcome().data_port);
  for (uint32_t frame = 1; frame <= 60; ++frame) {
    victim.send(owner.sealed_view(frame, static_cast<float>(frame)));
    if (frame % 10 == 0) victim.send(owner.sealed(DatagramKind::ping, std::vector<uint8_t>(protocol::kPingBytes)));
    std::this_thread::sleep_for(5ms);
    victim.listen();
    EXPECT_LE(victim.received(), 3 * victim.sent());
  }
  EXPECT_TRUE(eventually([&] { return count_of(Fault::path_unproven) > 0; })) << "three seconds";
  victim.listen();
  EXPECT_LE(victim.received(), 3 * victim.sent());
  EXPECT_EQ(victim.count_of(DatagramKind::frame_slice), 0u);
  EXPECT_EQ(victim.count_of(DatagramKind::path_challenge), PathValidation::kTries);
  EXPECT_EQ(victim.count_of(DatagramKind::pong), 6u);
}

TEST_F(Paths, AStreamCannotBeAimedAtAnAddressThatDoesNotAnswer) {
  start();
  TestClient owner = client();
  ASSERT_TRUE(owner.join(TestClient::hello(kScene, 640, 480)));
  expect_served(owner, 1);
  Stranger victim(owner.welcome().data_port);
  for (uint32_t frame = 2; frame <= 20; ++frame) {
    victim.send(owner.sealed_view(frame, static_cast<float>(frame)));
    EXPECT_TRUE(is_frame_of(owner, owner.receive_frame(frame), static_cast<float>(frame))) << "goes where it went";
  }
  victim.listen();
  EXPECT_LE(victim.received(), 3 * victim.sent());
  EXPECT_EQ(victim.count_of(DatagramKind::frame_slice), 0u);
}

TEST_F(Paths, AnOlderDatagramThatWasHeldBackMovesNothing) {
  start();
  TestClient c = client();
  ASSERT_TRUE(c.join(TestClient::hello(kScene)));
  const auto held = c.sealed_view(1, 1);
  expect_served(c, 2);
  Stranger thief(c.welcome().data_port);
  thief.send(held);
  EXPECT_TRUE(eventually([&] { return count_of(Fault::view_out_of_order) == 1; })) << "it has come";
  expect_served(c, 3);
  thief.listen();
  EXPECT_EQ(thief.received(), 0u) << "not even a challenge";
}

TEST_F(Paths, ANewestDatagramThatOvertakesItsOriginalMovesNothingEither) {
  start();
  TestClient c = client();
  ASSERT_TRUE(c.join(TestClient::hello(kScene)));
  expect_served(c, 1);
  Stranger thief(c.welcome().data_port);
  for (uint32_t frame = 2; frame <= 10; ++frame) {
    const auto raced = c.sealed_view(frame, static_cast<float>(frame));
    thief.send(raced);
    c.send_datagram(raced);
    EXPECT_TRUE(is_frame_of(c, c.receive_frame(frame), static_cast<float>(frame)));
  }
  thief.listen();
  EXPECT_EQ(thief.count_of(DatagramKind::frame_slice), 0u);
  EXPECT_GT(thief.count_of(DatagramKind::path_challenge), 0u);
}

TEST_F(Paths, AResumedSessionProvesItsAddressAnew) {
  start();
  TestClient first = client(), second = client();
  auto hello = TestClient::hello(kScene);
  hello.features |= protocol::kFeatureResume;
  ASSERT_TRUE(first.join(hello));
  expect_served(first, 1);
  ASSERT_TRUE(second.resume(first, false));
  second.send_view(2, 2);
  const auto challenge = second.receive_opened();
  ASSERT_TRUE(challenge);
  ASSERT_EQ(challenge->header.kind, DatagramKind::path_challenge);
  const std::vector<uint8_t> token(challenge->body.begin(), challenge->body.end());
  EXPECT_FALSE(second.receive_datagram(50ms));
  second.send_datagram(second.sealed(DatagramKind::path_response, token));
  EXPECT_TRUE(is_frame_of(second, second.receive_frame(2), 2));
}

TEST_F(Paths, ACameraSentAgainAfterAMoveIsAnsweredOnceMore) {
  start();
  TestClient c = client();
  ASSERT_TRUE(c.join(TestClient::hello(kScene)));
  expect_served(c, 1);
  c.send_view(1, 1);
  EXPECT_FALSE(c.receive_datagram(50ms)) << "only then";
  c.change_data_port();
  c.send_view(2, 2);  // its frame goes to the address before
  ASSERT_TRUE(c.validate_address());
  expect_served(c, 2);
}

}  // namespace
}  // namespace gnomon::daemon
