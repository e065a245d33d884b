// When a client whose server drains asks the door of its fleet.
#include "client/net/move_policy.h"

#include <gtest/gtest.h>

#include <set>

namespace gnomon::client {
namespace {

using namespace std::chrono_literals;
using protocol::Draining;

constexpr Draining kGo{40'000, Draining::kMoveNow};

protocol::Refused refused(protocol::RefusalCode code) {
  protocol::Refused said;
  said.code = code;
  return said;
}

TEST(MovePolicy, ClientsDoNotComeToTheDoorAllAtOnce) {
  std::multiset<Nanoseconds> waits;
  for (uint32_t client = 1; client <= 400; ++client) waits.insert(MovePolicy(client * 7919).told(kGo).value());
  EXPECT_GE(*waits.begin(), 0ns);
  EXPECT_LE(*waits.rbegin(), MovePolicy::kLongestSpread);
  EXPECT_GT(*waits.rbegin() - *waits.begin(), MovePolicy::kLongestSpread / 2);
}

TEST(MovePolicy, ThereIsTimeLeftHoweverSoonTheServerEnds) {
  for (const uint32_t deadline_ms : {0u, 100u, 2000u}) {
    const auto wait = MovePolicy(1).told({deadline_ms, Draining::kMoveNow});
    ASSERT_TRUE(wait);
    EXPECT_LE(*wait, std::chrono::milliseconds(deadline_ms) / 10);
  }
  EXPECT_LE(MovePolicy(1).told({Draining::kNoDeadline, Draining::kMoveNow}).value(), MovePolicy::kLongestSpread);
}

TEST(MovePolicy, NobodyMovesWhoIsNotAskedTo) {
  MovePolicy policy(1);
  EXPECT_FALSE(policy.told({40'000, 0}));
  EXPECT_FALSE(policy.wanted());
  EXPECT_FALSE(policy.wait_after(std::nullopt));
}

TEST(MovePolicy, WhatIsSaidTwiceBeginsOnceAndMayBeTakenBack) {
  MovePolicy policy(1);
  EXPECT_TRUE(policy.told(kGo));
  EXPECT_FALSE(policy.told(kGo));
  EXPECT_TRUE(policy.wanted());
  EXPECT_FALSE(policy.told({Draining::kNoDeadline, 0}));
  EXPECT_FALSE(policy.wanted());
  EXPECT_TRUE(policy.told(kGo));
  policy.moved();
  EXPECT_FALSE(policy.wanted());
  EXPECT_TRUE(policy.told(kGo)) << "the next server may drain, too";
}

TEST(MovePolicy, TriesAgainAtGrowingIntervals) {
  MovePolicy policy(1);
  policy.told(kGo);
  Nanoseconds least = MovePolicy::kFirstRetry;
  for (int i = 0; i < 8; ++i) {
    const auto wait = policy.wait_after(refused(protocol::RefusalCode::scene_unavailable));
    ASSERT_TRUE(wait);
    EXPECT_GE(*wait, least) << i;
    EXPECT_LE(*wait, 2 * least) << i;
    least = std::min(2 * least, MovePolicy::kLongestRetry);
  }
  EXPECT_TRUE(policy.wait_after(std::nullopt)) << "nobody has answered";
  EXPECT_FALSE(policy.wait_after(refused(protocol::RefusalCode::kept_out)));
}

}  // namespace
}  // namespace gnomon::client
