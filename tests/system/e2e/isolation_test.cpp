// What one client does, or a stranger, harms no other.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <random>

#include "protocol/messages.h"
#include "tests/system/e2e/daemon.h"
#include "tests/system/e2e/flier.h"

namespace gnomon::tests {
namespace {

class Isolation : public testing::Test {
 protected:
  Isolation() {
    for (const char* tenant : {"studio", "arcade"}) {
      fliers_.push_back(std::make_unique<Flier>(loop_, daemon_, tenant, living_room_path()));
    }
  }

  ~Isolation() override {
    for (const auto& flier : fliers_) {
      EXPECT_FALSE(flier->stream().connection().failure()) << flier->stream().connection().failure()->message;
      EXPECT_EQ(flier->stream().counters().invalid_slices, 0u);
    }
  }

  // Serves the fliers meanwhile.
  bool until(const std::function<bool()>& done) {
    const TimePoint end = Clock::now() + kPatience;
    while (!done()) {
      if (Clock::now() > end) return false;
      loop_.run_until(Clock::now() + std::chrono::milliseconds(50), [] { return false; });
    }
    return true;
  }

  std::unique_ptr<Process> another_client() {
    return std::make_unique<Process>(
        "gnomon-load",
        std::vector<std::string>{"--server", daemon_.server(), "--pin", daemon_.pin(), "--scene", "living_room",
                                 "--size", "160x90", "--rate", "20", "--seconds", "600", "--tenant", "arcade::1"},
        folder_.path());
  }

  TemporaryFolder folder_;
  Daemon daemon_;
  client::Loop loop_;
  Fliers fliers_;
};

TEST_F(Isolation, AKilledAndASilentClientAreReapedWhileOthersFlyOn) {
  ASSERT_TRUE(all_progress(loop_, fliers_, 2));
  const auto killed = another_client();
  const auto silent = another_client();
  ASSERT_TRUE(until([&] { return daemon_.sessions() == 4; })) << killed->output() << silent->output();
  killed->signal(SIGKILL);
  silent->signal(SIGSTOP);  // its connection stays open, nothing comes from it any more
  EXPECT_TRUE(all_progress(loop_, fliers_, 5));
  EXPECT_TRUE(until([&] { return daemon_.sessions() == 2; }));
  EXPECT_TRUE(all_progress(loop_, fliers_, 2));
}

// A socket of the test's own to one of the daemon's ports.
class Stranger {
 public:
  Stranger(int type, uint16_t port) : socket_(socket(AF_INET, type, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    static_cast<void>(connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address));
  }
  ~Stranger() { close(socket_); }
  Stranger(const Stranger&) = delete;

  void say(std::span<const uint8_t> bytes) const { send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }
  bool hears_something() const {
    uint8_t byte;
    return recv(socket_, &byte, 1, MSG_DONTWAIT) > 0;
  }

 private:
  int socket_;
};

std::vector<uint8_t> random_bytes(std::mt19937& random, size_t count) {
  std::vector<uint8_t> bytes(count);
  for (auto& byte : bytes) byte = static_cast<uint8_t>(random());
  return bytes;
}

TEST_F(Isolation, JunkDatagramsGetNoAnswerAndChangeNothing) {
  ASSERT_TRUE(all_progress(loop_, fliers_, 2));
  const auto& welcome = fliers_[0]->stream().connection().welcome();
  std::mt19937 random(3);
  const Stranger stranger(SOCK_DGRAM, daemon_.data_port());
  // Noise; true headers with forged tags; true datagrams of a session with another key.
  protocol::Seal forger(welcome.session, welcome.cipher, {}, protocol::Side::client);
  for (int i = 0; i < 2000; ++i) {
    stranger.say(random_bytes(random, random() % 1400));
    std::vector<uint8_t> forged;
    forger.seal(protocol::DatagramKind::camera_update, random_bytes(random, 65), forged);
    stranger.say(forged);
    stranger.say(std::span(forged).first(random() % forged.size()));
    if (i % 100 == 0) loop_.poll();
  }
  EXPECT_TRUE(all_progress(loop_, fliers_, 5));
  EXPECT_FALSE(stranger.hears_something()) << "nothing is sent to an address that has not proved itself";
  EXPECT_TRUE(until([&] { return daemon_.metric("gnomon_datagrams_rejected_total", {"reason=\"forged\""}) > 0; }));
  EXPECT_TRUE(until([&] { return daemon_.metric("gnomon_datagrams_rejected_total", {"reason=\"header\""}) > 0; }));
  EXPECT_EQ(daemon_.sessions(), 2);
}

TEST_F(Isolation, JunkOnTheControlPortIsRefusedAndChangesNothing) {
  ASSERT_TRUE(all_progress(loop_, fliers_, 2));
  std::mt19937 random(4);
  std::vector<std::unique_ptr<Stranger>> strangers;
  protocol::Hello true_hello;
  true_hello.scene = "living_room";
  const auto hello = protocol::encode(true_hello);
  for (int i = 0; i < 60; ++i) {
    strangers.push_back(std::make_unique<Stranger>(SOCK_STREAM, daemon_.address().port));
    switch (i % 3) {
      case 0: strangers.back()->say(random_bytes(random, 1 + random() % 5000)); break;
      case 1: strangers.back()->say(std::span(hello).first(random() % hello.size())); break;
      case 2: break;  // says nothing at all
    }
  }
  EXPECT_TRUE(all_progress(loop_, fliers_, 5));
  EXPECT_TRUE(until([&] { return daemon_.metric("gnomon_refusals_total", {"reason=\"tls\""}) > 0; }));
  EXPECT_TRUE(until([&] { return daemon_.metric("gnomon_refusals_total", {"reason=\"handshake_timeout\""}) > 0; }));
  EXPECT_EQ(daemon_.sessions(), 2);
}

}  // namespace
}  // namespace gnomon::tests
