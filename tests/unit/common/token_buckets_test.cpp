#include "common/token_buckets.h"

#include <gtest/gtest.h>

#include <string>

namespace gnomon {
namespace {

using namespace std::chrono_literals;

TEST(TokenBuckets, GivesABurstThenARate) {
  TokenBuckets<std::string> rate(5, 10);
  const std::string here = "192.0.2.1", there = "192.0.2.2";
  TimePoint now{1h};
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(rate.take(here, 1, now)) << i;
  EXPECT_FALSE(rate.take(here, 1, now));
  EXPECT_TRUE(rate.take(there, 1, now)) << "others are not to suffer";
  now += 100ms;
  EXPECT_TRUE(rate.take(here, 1, now));
  EXPECT_FALSE(rate.take(here, 1, now));
  now += 1h;
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(rate.take(here, 1, now)) << i;
  EXPECT_FALSE(rate.take(here, 1, now)) << "no more is saved up";
}

TEST(TokenBuckets, RemembersABoundedNumberOfKeys) {
  TokenBuckets<std::string> rate(2, 1);
  for (uint32_t i = 0; i < 3 * TokenBuckets<std::string>::kMaxKeys; ++i) {
    EXPECT_TRUE(rate.take(std::to_string(i), 1, TimePoint(1h)));
    ASSERT_LE(rate.size(), TokenBuckets<std::string>::kMaxKeys);
  }
}

TEST(TokenBuckets, AFloodOfFreshAddressesWinsNothingForWhoHasSpentTheirs) {
  TokenBuckets<std::string> rate(3, 1);
  const TimePoint now{1h};
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(rate.take("192.0.2.1", 1, now));
  for (uint32_t i = 0; i < 3 * TokenBuckets<std::string>::kMaxKeys; ++i)
    EXPECT_TRUE(rate.take(std::to_string(i), 1, now)) << i;
  EXPECT_FALSE(rate.take("192.0.2.1", 1, now)) << "it is still remembered";
}

TEST(TokenBuckets, WhatCostsMoreTakesMore) {
  TokenBuckets<std::string> rate(10, 2);
  TimePoint now{1h};
  EXPECT_TRUE(rate.take("here", 8, now));
  EXPECT_FALSE(rate.take("here", 3, now));
  EXPECT_TRUE(rate.take("here", 2, now)) << "nothing was taken for what was refused";
  now += 1s;
  EXPECT_FALSE(rate.take("here", 3, now));
  EXPECT_TRUE(rate.take("here", 2, now));
}

}  // namespace
}  // namespace gnomon
