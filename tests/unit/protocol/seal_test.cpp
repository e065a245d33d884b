#include "protocol/seal.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

#include "protocol/replay_window.h"

namespace gnomon::protocol {
namespace {

using Bytes = std::vector<uint8_t>;

constexpr SessionId kSession{0x1234567890abcdef};
constexpr SealSecrets kSecrets{{1, 2, 3, 4, 5, 6, 7, 8}, {9, 10, 11, 12}};

// Every test runs with both ciphers.
struct SealTest : testing::TestWithParam<CipherId> {
  Seal make(Side side, SessionId session = kSession, const SealSecrets& secrets = kSecrets,
            uint64_t epoch_datagrams = kEpochDatagrams) const {
    return Seal(session, GetParam(), secrets, side, epoch_datagrams);
  }
  Seal client = make(Side::client);
  Seal server = make(Side::server);

  static Bytes sealed(Seal& seal, const Bytes& body = {1, 2, 3, 4, 5}) {
    Bytes datagram;
    seal.seal(DatagramKind::camera_update, body, datagram);
    return datagram;
  }

  void expect_rejected(const Bytes& datagram, Rejection why, Seal& by) {
    EXPECT_FALSE(by.open(datagram));
    EXPECT_EQ(static_cast<int>(by.rejection()), static_cast<int>(why));
  }
};

INSTANTIATE_TEST_SUITE_P(Ciphers, SealTest, testing::Values(CipherId::aes_128_gcm, CipherId::chacha20_poly1305),
                         [](const auto& instance) {
                           return instance.param == CipherId::aes_128_gcm ? "aes_128_gcm" : "chacha20_poly1305";
                         });

TEST_P(SealTest, OpensWhatTheOtherSideSealed) {
  for (uint64_t sequence = 1; sequence < 50; ++sequence) {
    const Bytes body((sequence - 1) * 20, static_cast<uint8_t>(sequence));
    Bytes datagram;
    server.seal(DatagramKind::frame_slice, body, datagram);
    EXPECT_EQ(datagram.size(), kHeaderBytes + body.size() + kTagBytes);
    const auto opened = client.open(datagram);
    ASSERT_TRUE(opened);
    EXPECT_EQ(opened->header, (Header{DatagramKind::frame_slice, 0, kSession, sequence}));
    EXPECT_TRUE(std::equal(opened->body.begin(), opened->body.end(), body.begin(), body.end()));
  }
}

// A successor of a side that has ended has nothing but its state.
TEST_P(SealTest, GoesOnFromItsState) {
  constexpr uint64_t kEpoch = 16;
  SealState state = first_state(kSecrets, Side::server);
  Seal peer = make(Side::client, kSession, kSecrets, kEpoch);
  std::set<uint64_t> numbers;
  Bytes old;
  for (int life = 0; life < 12; ++life) {
    Seal seal(kSession, GetParam(), state, Side::server, kEpoch);
    if (!old.empty()) expect_rejected(old, Rejection::replayed, seal);
    for (int i = 0; i < 1 + life * 3 % 7; ++i) {
      const Bytes datagram = sealed(seal);
      const auto opened = peer.open(datagram);
      ASSERT_TRUE(opened) << "life " << life;
      EXPECT_TRUE(numbers.insert(opened->header.sequence).second) << "a number twice";
      old = sealed(peer);
      ASSERT_TRUE(seal.open(old)) << "life " << life;
    }
  }
  EXPECT_GT(*numbers.rbegin(), 2 * kEpoch);
  EXPECT_EQ(state.sent, *numbers.rbegin());
  const EpochSecret& at = state.sending;
  EXPECT_EQ(at.epoch, state.sent / kEpoch);
  EXPECT_NE(at.secret(), Secret{});
  EXPECT_EQ(at.by_parity[(at.epoch + 1) % 2], Secret{}) << "what sealed earlier epochs is not kept";
}

TEST_P(SealTest, NumbersThatGoAnotherWayBeginEpochsToo) {
  constexpr uint64_t kEpoch = 16;
  Seal here = make(Side::server, kSession, kSecrets, kEpoch),
       there = make(Side::client, kSession, kSecrets, kEpoch);
  for (int i = 0; i < 100; ++i) there.pass(here.skip());
  EXPECT_TRUE(there.open(sealed(here)));
}

TEST_P(SealTest, ABodyMayStandWhereItIsSealed) {
  const Bytes body = {7, 8, 9, 10};
  Bytes in_place(Seal::sealed_size(body.size()));
  std::copy(body.begin(), body.end(), in_place.begin() + kHeaderBytes);
  Seal twin = make(Side::client);
  client.seal(DatagramKind::camera_update, std::span(in_place).subspan(kHeaderBytes, body.size()), in_place);
  EXPECT_EQ(in_place, sealed(twin, body));
}

TEST_P(SealTest, BodiesAreNotToBeReadAndEqualOnesLookDifferent) {
  const Bytes body(64, 'x');
  const Bytes first = sealed(client, body), second = sealed(client, body);
  const auto body_of = [](const Bytes& datagram) { return Bytes(datagram.begin() + kHeaderBytes, datagram.end()); };
  EXPECT_EQ(std::search(first.begin(), first.end(), body.begin(), body.begin() + 8), first.end());
  EXPECT_NE(body_of(first), body_of(second));
}

TEST_P(SealTest, EveryFlippedBitIsFound) {
  const Bytes datagram = sealed(client);
  std::map<Rejection, int> reasons;
  for (size_t bit = 0; bit < datagram.size() * 8; ++bit) {
    Bytes damaged = datagram;
    damaged[bit / 8] ^= static_cast<uint8_t>(1u << bit % 8);
    EXPECT_FALSE(server.open(damaged)) << "bit " << bit;
    ++reasons[server.rejection()];
  }
  EXPECT_EQ(reasons[Rejection::session], 64) << "the session's id";
  EXPECT_GT(reasons[Rejection::forged], 16 * 8) << "flags, body and tag at least";
  EXPECT_TRUE(server.open(datagram)) << "damaged ones must not use up the sequence number";
}

TEST_P(SealTest, EveryTruncationAndExtensionIsFound) {
  Bytes datagram = sealed(client);
  for (size_t size = 0; size < datagram.size(); ++size) {
    EXPECT_FALSE(server.open(std::span(datagram).first(size))) << size;
  }
  datagram.push_back(0);
  expect_rejected(datagram, Rejection::forged, server);
}

TEST_P(SealTest, PiecesOfTwoDatagramsMakeNoThird) {
  const Bytes a = sealed(client, Bytes(40, 1)), b = sealed(client, Bytes(40, 2));
  for (size_t cut = 1; cut < a.size(); ++cut) {
    Bytes spliced(a.begin(), a.begin() + static_cast<ptrdiff_t>(cut));
    spliced.insert(spliced.end(), b.begin() + static_cast<ptrdiff_t>(cut), b.end());
    if (spliced == a || spliced == b) continue;
    EXPECT_FALSE(server.open(spliced)) << cut;
  }
  EXPECT_TRUE(server.open(a));
  EXPECT_TRUE(server.open(b));
}

TEST_P(SealTest, DatagramsBeyondTheLimitAreRefused) {
  const size_t largest = kMaxDatagramBytes - kHeaderBytes - kTagBytes;
  EXPECT_TRUE(server.open(sealed(client, Bytes(largest))));
  expect_rejected(sealed(client, Bytes(largest + 1)), Rejection::header, server);
}

TEST_P(SealTest, RandomBytesAreRefused) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    const Bytes good = sealed(client);
    Bytes bad = good;
    for (size_t at = random() % bad.size(); at < bad.size(); ++at) bad[at] = static_cast<uint8_t>(random());
    if (bad != good) {
      EXPECT_FALSE(server.open(bad));
    }
  }
}

TEST_P(SealTest, AReplayIsRefused) {
  const Bytes first = sealed(client);
  const Bytes second = sealed(client);
  EXPECT_TRUE(server.open(first));
  expect_rejected(first, Rejection::replayed, server);
  EXPECT_TRUE(server.open(second));
  expect_rejected(first, Rejection::replayed, server);
  expect_rejected(second, Rejection::replayed, server);
}

TEST_P(SealTest, DatagramsOfAnotherSessionSecretCipherOrDirectionAreRefused) {
  Seal other_session = make(Side::client, SessionId{kSession.value + 1});
  expect_rejected(sealed(other_session), Rejection::session, server);
  Bytes renamed = sealed(other_session);
  const Bytes own = sealed(client);
  std::copy(own.begin() + 4, own.begin() + 12, renamed.begin() + 4);
  expect_rejected(renamed, Rejection::forged, server);

  SealSecrets secrets = kSecrets;
  secrets.client[31] ^= 1;
  Seal other_secret = make(Side::client, kSession, secrets);
  expect_rejected(sealed(other_secret), Rejection::forged, server);
  const bool aes = GetParam() == CipherId::aes_128_gcm;
  Seal other_cipher(kSession, aes ? CipherId::chacha20_poly1305 : CipherId::aes_128_gcm, kSecrets, Side::client);
  expect_rejected(sealed(other_cipher), Rejection::forged, server);
  expect_rejected(sealed(server), Rejection::forged, server);  // its own datagram, sent back
  expect_rejected(sealed(client), Rejection::forged, client);
}

TEST_P(SealTest, TheWindowTakesReorderedDatagramsAndDropsOldOnes) {
  std::vector<Bytes> datagrams;
  for (uint64_t i = 0; i < ReplayWindow::kSize + 2; ++i) datagrams.push_back(sealed(client));
  EXPECT_TRUE(server.open(datagrams.back()));
  EXPECT_FALSE(server.open(datagrams[0])) << "1,025 behind the newest";
  EXPECT_FALSE(server.open(datagrams[1])) << "1,024 behind the newest";
  for (size_t i = datagrams.size() - 2; i >= 2; --i) EXPECT_TRUE(server.open(datagrams[i])) << i;
  for (const Bytes& datagram : datagrams) EXPECT_FALSE(server.open(datagram));
}

struct Epochs : SealTest {
  static constexpr uint64_t kLength = 8;
  Seal sender = make(Side::client, kSession, kSecrets, kLength);
  Seal receiver = make(Side::server, kSession, kSecrets, kLength);

  // Datagrams with the sequence numbers 1 to `count`, each at its number.
  std::vector<Bytes> send(size_t count) {
    std::vector<Bytes> datagrams(1);
    while (datagrams.size() <= count) datagrams.push_back(sealed(sender));
    return datagrams;
  }
};

INSTANTIATE_TEST_SUITE_P(Ciphers, Epochs, testing::Values(CipherId::aes_128_gcm, CipherId::chacha20_poly1305));

TEST_P(Epochs, KeysChangeAndNobodyNotices) {
  const auto datagrams = send(100);
  for (size_t i = 1; i < datagrams.size(); ++i) EXPECT_TRUE(receiver.open(datagrams[i])) << i;
}

TEST_P(Epochs, EachHasKeysOfItsOwn) {
  Seal one_key = make(Side::client);
  const auto datagrams = send(2 * kLength);
  for (size_t i = 1; i < datagrams.size(); ++i) {
    EXPECT_EQ(sealed(one_key) == datagrams[i], i < kLength) << i;
  }
}

TEST_P(Epochs, TheOneBeforeIsStillTaken) {
  const auto datagrams = send(3 * kLength);
  EXPECT_TRUE(receiver.open(datagrams[kLength]));
  EXPECT_TRUE(receiver.open(datagrams[kLength - 1]));
  EXPECT_TRUE(receiver.open(datagrams[2 * kLength])) << "begins epoch 2";
  EXPECT_TRUE(receiver.open(datagrams[kLength + 1]));
  EXPECT_TRUE(receiver.open(datagrams[2 * kLength - 1]));
  expect_rejected(datagrams[1], Rejection::replayed, receiver);  // its key is not kept any more
}

TEST_P(Epochs, AWholeOneMayBeLostButNotMore) {
  const auto datagrams = send(5 * kLength);
  EXPECT_TRUE(receiver.open(datagrams[1]));
  expect_rejected(datagrams[2 * kLength], Rejection::replayed, receiver);
  EXPECT_TRUE(receiver.open(datagrams[2 * kLength - 1]));
  EXPECT_TRUE(receiver.open(datagrams[2 * kLength]));
}

TEST_P(Epochs, AForgedNumberMovesNothing) {
  const auto datagrams = send(4 * kLength);
  EXPECT_TRUE(receiver.open(datagrams[1]));
  Bytes forged = datagrams[2];
  forged[12] = static_cast<uint8_t>(kLength);  // a sequence number of the next epoch
  for (int i = 0; i < 3; ++i) expect_rejected(forged, Rejection::forged, receiver);
  for (size_t i = 2; i < datagrams.size(); ++i) EXPECT_TRUE(receiver.open(datagrams[i])) << i;
}

// The window decides as a set of all numbers ever seen would.
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
      ASSERT_EQ(window.is_new(sequence), is_new);
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
