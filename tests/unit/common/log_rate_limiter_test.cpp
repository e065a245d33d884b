#include "common/log_rate_limiter.h"

#include <gtest/gtest.h>

namespace gnomon::log {
namespace {

using namespace std::chrono_literals;

TEST(LogRateLimiter, ABurstPassesThenARateAndTheRestIsCounted) {
  LogRateLimiter repeats(5, 2);
  TimePoint now(1h);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(repeats.admit("refused", now), 0u);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(repeats.admit("refused", now), std::nullopt);
  now += 500ms;
  EXPECT_EQ(repeats.admit("refused", now), 100u);
  EXPECT_EQ(repeats.admit("refused", now), std::nullopt);
  now += 500ms;
  EXPECT_EQ(repeats.admit("refused", now), 1u);
}

TEST(LogRateLimiter, EventsDoNotTakeEachOthersPlace) {
  LogRateLimiter repeats(1, 1);
  const TimePoint now(1h);
  EXPECT_TRUE(repeats.admit("refused", now));
  EXPECT_FALSE(repeats.admit("refused", now));
  EXPECT_TRUE(repeats.admit("device lost", now));
}

TEST(LogRateLimiter, RestGivesTheBurstBackAndNoMore) {
  LogRateLimiter repeats(3, 1);
  TimePoint now(1h);
  while (repeats.admit("refused", now)) {
  }
  now += 1h;
  EXPECT_EQ(repeats.admit("refused", now), 1u);
  EXPECT_TRUE(repeats.admit("refused", now));
  EXPECT_TRUE(repeats.admit("refused", now));
  EXPECT_FALSE(repeats.admit("refused", now));
}

}  // namespace
}  // namespace gnomon::log
