#include "protocol/seal.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "protocol/replay_window.h"

namespace gnomon::protocol {
namespace {

using Bytes = std::vector<uint8_t>;

constexpr SessionId kSession{0x1234567890abcdef};
constexpr Bytes16 kKey = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};

struct SealTest : testing::Test {
  std::unique_ptr<Seal> client = make_clear_seal(kSession, kKey, Side::client);
  std::unique_ptr<Seal> server = make_clear_seal(kSession, kKey, Side::server);

  static Bytes sealed(Seal& seal, const Bytes& body = {1, 2, 3, 4, 5}) {
    Bytes datagram;
    seal.seal(DatagramKind::camera_update, body, datagram);
    return datagram;
  }
};

TEST_F(SealTest, OpensWhatTheOtherSideSealed) {
  for (uint64_t sequence = 1; sequence < 50; ++sequence) {
    const Bytes body(sequence * 20, static_cast<uint8_t>(sequence));
    Bytes datagram;
    server->seal(DatagramKind::frame_slice, body, datagram);
    EXPECT_EQ(datagram.size(), kHeaderBytes + body.size() + kTagBytes);
    const auto opened = client->open(datagram);
    ASSERT_TRUE(opened);
    EXPECT_EQ(opened->header, (Header{DatagramKind::frame_slice, 0, kSession, sequence}));
    EXPECT_TRUE(std::equal(opened->body.begin(), opened->body.end(), body.begin(), body.end()));
  }
}

TEST_F(SealTest, EveryFlippedBitIsFound) {
  const Bytes datagram = sealed(*client);
  for (size_t bit = 0; bit < datagram.size() * 8; ++bit) {
    Bytes damaged = datagram;
    damaged[bit / 8] ^= static_cast<uint8_t>(1u << bit % 8);
    EXPECT_FALSE(server->open(damaged)) << "bit " << bit;
  }
  EXPECT_TRUE(server->open(datagram)) << "damaged ones must not use up the sequence number";
}

TEST_F(SealTest, EveryTruncationAndExtensionIsFound) {
  Bytes datagram = sealed(*client);
  for (size_t size = 0; size < datagram.size(); ++size) {
    EXPECT_FALSE(server->open(std::span(datagram).first(size))) << size;
  }
  datagram.push_back(0);
  EXPECT_FALSE(server->open(datagram));
}

TEST_F(SealTest, DatagramsBeyondTheLimitAreRefused) {
  const size_t largest = kMaxDatagramBytes - kHeaderBytes - kTagBytes;
  EXPECT_TRUE(server->open(sealed(*client, Bytes(largest))));
  EXPECT_FALSE(server->open(sealed(*client, Bytes(largest + 1))));
}

TEST_F(SealTest, RandomBytesAreRefused) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    const Bytes good = sealed(*client);
    Bytes bad = good;
    for (size_t at = random() % bad.size(); at < bad.size(); ++at) bad[at] = static_cast<uint8_t>(random());
    if (bad != good) {
      EXPECT_FALSE(server->open(bad));
    }
  }
}

TEST_F(SealTest, AReplayIsRefused) {
  const Bytes first = sealed(*client);
  const Bytes second = sealed(*client);
  EXPECT_TRUE(server->open(first));
  EXPECT_FALSE(server->open(first));
  EXPECT_TRUE(server->open(second));
  EXPECT_FALSE(server->open(first));
  EXPECT_FALSE(server->open(second));
}

TEST_F(SealTest, DatagramsOfAnotherSessionKeyOrDirectionAreRefused) {
  auto other_session = make_clear_seal(SessionId{kSession.value + 1}, kKey, Side::client);
  Bytes16 key = kKey;
  key[15] ^= 1;
  auto other_key = make_clear_seal(kSession, key, Side::client);
  EXPECT_FALSE(server->open(sealed(*other_session)));
  EXPECT_FALSE(server->open(sealed(*other_key)));
  EXPECT_FALSE(server->open(sealed(*server))) << "its own datagram, sent back";
  EXPECT_FALSE(client->open(sealed(*client)));
}

TEST_F(SealTest, TheWindowTakesReorderedDatagramsAndDropsOldOnes) {
  std::vector<Bytes> datagrams;
  for (uint64_t i = 0; i < ReplayWindow::kSize + 2; ++i) datagrams.push_back(sealed(*client));
  EXPECT_TRUE(server->open(datagrams.back()));
  EXPECT_FALSE(server->open(datagrams[0])) << "1,025 behind the newest";
  EXPECT_FALSE(server->open(datagrams[1])) << "1,024 behind the newest";
  for (size_t i = datagrams.size() - 2; i >= 2; --i) EXPECT_TRUE(server->open(datagrams[i])) << i;
  for (const Bytes& datagram : datagrams) EXPECT_FALSE(server->open(datagram));
}

// The same decisions as a set of all numbers ever seen.
TEST(ReplayWindow, EqualsASetOfWhatWasSeen) {
  std::mt19937_64 random(2);
  for (int run = 0; run < 20; ++run) {
    ReplayWindow window;
    std::set<uint64_t> seen = {0};
    uint64_t base = random() % 5;
    for (int i = 0; i < 5000; ++i) {
      if (random() % 4 == 0) base += random() % 3;
      if (random() % 500 == 0) base += random() % 3000;
      const uint64_t back = random() % (random() % 8 == 0 ? 1400 : 40);
      const uint64_t sequence = base + 20 - std::min(back, base + 20);
      const bool is_new = *seen.rbegin() < sequence + ReplayWindow::kSize && seen.insert(sequence).second;
      ASSERT_EQ(window.take(sequence), is_new) << "sequence " << sequence << ", newest " << *seen.rbegin();
    }
  }
}

TEST(ReplayWindow, TakesTheLargestNumbers) {
  ReplayWindow window;
  EXPECT_FALSE(window.take(0));
  EXPECT_TRUE(window.take(UINT64_MAX - 1));
  EXPECT_TRUE(window.take(UINT64_MAX));
  EXPECT_FALSE(window.take(UINT64_MAX));
  EXPECT_FALSE(window.take(1));
}

}  // namespace
}  // namespace gnomon::protocol
