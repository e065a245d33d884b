// To which address a session's datagrams may go, with a clock that the test advances.
#include "daemon/session/path_validation.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;
using Endpoint = PathValidation::Endpoint;

constexpr TimePoint kStart{1h};
constexpr size_t kView = 101;  // bytes of a camera update

Endpoint address(const char* host, uint16_t port = 1000) { return {asio::ip::make_address(host), port}; }

class PathTest : public testing::Test {
 protected:
  static std::function<uint64_t()> random() {
    return [engine = std::mt19937_64(5)]() mutable { return engine(); };
  }
  // A newest camera update from there.
  void view(const Endpoint& from, TimePoint now) { path_.received(from, kView, true, true, now); }

  // The address is proved at once.
  void validate(const Endpoint& from) {
    view(from, kStart);
    const auto challenge = path_.challenge_due(kStart);
    ASSERT_TRUE(challenge && path_.answered(challenge->token));
    ASSERT_EQ(path_.current(), from);
  }

  const Endpoint here_ = address("192.0.2.1"), there_ = address("198.51.100.1");
  PathValidation path_{true, random()};
};

TEST_F(PathTest, AnAddressIsCurrentOnceItsTokenHasComeBack) {
  EXPECT_FALSE(path_.challenge_due(kStart));
  EXPECT_EQ(path_.wake_at(), TimePoint::max());
  view(here_, kStart);
  EXPECT_FALSE(path_.current());
  const auto challenge = path_.challenge_due(kStart);
  ASSERT_TRUE(challenge);
  EXPECT_EQ(challenge->to, here_);
  EXPECT_FALSE(path_.answered(challenge->token + 1));
  EXPECT_FALSE(path_.current());
  const auto move = path_.answered(challenge->token);
  ASSERT_TRUE(move);
  EXPECT_FALSE(move->other_host) << "there was none before";
  EXPECT_EQ(path_.current(), here_);
  EXPECT_FALSE(path_.answered(challenge->token)) << "once";
  EXPECT_EQ(path_.wake_at(), TimePoint::max());
}

TEST_F(PathTest, AClientWithoutTheFeatureIsBelieved) {
  PathValidation believed(false, random());
  believed.received(here_, kView, true, false, kStart);
  EXPECT_FALSE(believed.current()) << "a Ping tells nothing";
  believed.received(here_, kView, true, true, kStart);
  EXPECT_EQ(believed.current(), here_);
  believed.received(there_, kView, false, true, kStart);
  EXPECT_EQ(believed.current(), here_) << "it was held back";
  believed.received(there_, kView, true, true, kStart);
  EXPECT_EQ(believed.current(), there_);
  EXPECT_FALSE(believed.challenge_due(kStart));
}

TEST_F(PathTest, OnlyTheNewestDatagramBeginsAMove) {
  validate(here_);
  path_.received(there_, kView, false, true, kStart);
  EXPECT_FALSE(path_.is_pending());
  path_.received(there_, 1200, true, false, kStart);
  EXPECT_FALSE(path_.is_pending()) << "a Ping tries a path";
  view(there_, kStart);
  EXPECT_TRUE(path_.is_pending());
  EXPECT_EQ(path_.current(), here_) << "until the other one is proved";
}

TEST_F(PathTest, AMoveSaysWhetherTheHostIsAnotherOne) {
  validate(here_);
  const Endpoint rebound = address("192.0.2.1", 2000);
  view(rebound, kStart);
  const auto port = path_.answered(path_.challenge_due(kStart)->token);
  ASSERT_TRUE(port);
  EXPECT_FALSE(port->other_host);
  EXPECT_TRUE(port->streams);
  view(there_, kStart);
  const auto host = path_.answered(path_.challenge_due(kStart)->token);
  ASSERT_TRUE(host);
  EXPECT_TRUE(host->other_host);
  EXPECT_EQ(path_.current(), there_);
}

TEST_F(PathTest, AFirstPingIsEnoughToBeginAndSaysNothingOfTheStream) {
  path_.received(here_, 1200, true, false, kStart);
  const auto move = path_.answered(path_.challenge_due(kStart)->token);
  ASSERT_TRUE(move);
  EXPECT_FALSE(move->streams);
  EXPECT_EQ(path_.current(), here_);
}

TEST_F(PathTest, AClientThatIsBackEndsTheMove) {
  validate(here_);
  view(there_, kStart);
  const auto challenge = path_.challenge_due(kStart);
  ASSERT_TRUE(challenge);
  path_.received(here_, kView, false, true, kStart);
  EXPECT_TRUE(path_.is_pending()) << "a late one from before the move";
  view(here_, kStart);
  EXPECT_FALSE(path_.is_pending());
  EXPECT_FALSE(path_.answered(challenge->token));
  EXPECT_EQ(path_.current(), here_);
}

TEST_F(PathTest, ChallengesAreRepeatedAFewTimesEachWithItsOwnToken) {
  validate(here_);
  view(there_, kStart);
  std::set<uint64_t> tokens;
  std::vector<Nanoseconds> times;
  uint64_t first = 0;
  for (TimePoint now = kStart; now < kStart + 10s; now = path_.wake_at()) {
    while (const auto challenge = path_.challenge_due(now)) {
      if (tokens.empty()) first = challenge->token;
      EXPECT_EQ(challenge->to, there_);
      tokens.insert(challenge->token);
      times.push_back(now - kStart);
    }
    if (now - kStart >= 2s) break;
  }
  EXPECT_EQ(times, (std::vector<Nanoseconds>{0ms, 200ms, 600ms, 1400ms}));
  EXPECT_EQ(tokens.size(), PathValidation::kTries);
  EXPECT_TRUE(path_.answered(first)) << "the answer to any of them";
  EXPECT_EQ(path_.current(), there_);
}

TEST_F(PathTest, AnAddressThatFailsLeavesTheOneBefore) {
  validate(here_);
  view(there_, kStart);
  const auto challenge = path_.challenge_due(kStart);
  EXPECT_FALSE(path_.take_failure(kStart + PathValidation::kPatience - 1ns));
  EXPECT_TRUE(path_.take_failure(kStart + PathValidation::kPatience));
  EXPECT_FALSE(path_.take_failure(kStart + PathValidation::kPatience)) << "once";
  EXPECT_FALSE(path_.answered(challenge->token)) << "too late";
  EXPECT_EQ(path_.current(), here_);
  EXPECT_EQ(path_.wake_at(), TimePoint::max());
  view(there_, kStart + 4s);
  EXPECT_TRUE(path_.challenge_due(kStart + 4s)) << "it may try again";
}

TEST_F(PathTest, ChallengesWaitForTheBytesThatTheyMayAnswer) {
  const auto challenges = [&](TimePoint now) {
    size_t count = 0;
    while (path_.challenge_due(now)) ++count;
    return count;
  };
  path_.received(here_, 36, true, true, kStart);
  EXPECT_EQ(challenges(kStart) + challenges(kStart + 200ms) + challenges(kStart + 600ms), 2u) << "88 of 108 bytes";
  EXPECT_EQ(path_.wake_at(), kStart + PathValidation::kPatience) << "and nobody is woken in vain";
  path_.received(there_, 36, false, true, kStart + 600ms);
  EXPECT_EQ(challenges(kStart + 600ms), 0u) << "from elsewhere";
  path_.received(here_, 36, false, true, kStart + 600ms);
  EXPECT_EQ(challenges(kStart + 600ms), 1u);
  path_.sent(here_, 216 - 3 * PathValidation::kChallengeBytes);
  EXPECT_EQ(challenges(kStart + 1400ms), 0u) << "what else went there counts too";
}

// Whatever comes from whatever addresses: none that does not answer gets more than three times its own bytes.
TEST_F(PathTest, ASilentAddressGetsAtMostThreeTimesItsBytes) {
  std::mt19937_64 random(7);
  for (int round = 0; round < 200; ++round) {
    PathValidation path(true, [&] { return random(); });
    std::map<Endpoint, size_t> from, to;
    TimePoint now = kStart;
    size_t challenges = 0;
    for (int i = 0; i < 300; ++i) {
      const Endpoint source = address("203.0.113.7", static_cast<uint16_t>(1 + random() % (1 + round % 5)));
      const bool ping = random() % 4 == 0;
      const size_t bytes = ping ? 1200 : 36 + random() % 100;
      from[source] += bytes;
      path.received(source, bytes, random() % 3 != 0, !ping, now);
      if (ping) {
        path.sent(source, bytes);
        to[source] += bytes;
      }
      while (const auto challenge = path.challenge_due(now)) {
        to[challenge->to] += PathValidation::kChallengeBytes;
        ++challenges;
      }
      for (const auto& [at, sent] : to) ASSERT_LE(sent, 3 * from[at]);
      path.take_failure(now);
      EXPECT_FALSE(path.current());
      now += std::chrono::microseconds(random() % 400'000);
    }
    EXPECT_GT(challenges, 10u);
  }
}

}  // namespace
}  // namespace gnomon::daemon
