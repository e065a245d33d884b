#include "scheduler/worst_rate.h"

#include <gtest/gtest.h>

namespace gnomon::scheduler {
namespace {

using namespace std::chrono_literals;

constexpr Nanoseconds kLimit = 10ms, kTelling = 3ms;
constexpr uint64_t kUnknown = 1 << 20;

TEST(WorstRate, IsThatOfTheSecondDearestJobOfSomeLength) {
  WorstRate worst;
  EXPECT_EQ(worst.bits_within(kLimit, kUnknown), kUnknown);
  worst.learn(10, 2ms, kTelling);
  worst.learn(10, 2ms, kTelling);
  EXPECT_EQ(worst.bits_within(kLimit, kUnknown), kUnknown) << "too short to tell";
  worst.learn(1000, 1s, kTelling);
  EXPECT_EQ(worst.bits_within(kLimit, kUnknown), kUnknown) << "it was delayed, as far as one can know";
  worst.learn(1000, 20ms, kTelling);
  EXPECT_EQ(worst.bits_within(kLimit, kUnknown), 500u);
  worst.learn(1000, 15ms, kTelling);
  EXPECT_EQ(worst.bits_within(kLimit, kUnknown), 500u) << "a cheaper one changes nothing";
  worst.learn(1000, 40ms, kTelling);
  EXPECT_EQ(worst.bits_within(kLimit, kUnknown), 250u);
}

TEST(WorstRate, IsForgottenAfterDeviceTimeAndNotByCheapFrames) {
  WorstRate worst;
  for (int i = 0; i < 2; ++i) worst.learn(1000, 20ms, kTelling);
  for (int i = 0; i < 1'000'000; ++i) worst.learn(1 << 20, 1us, kTelling);
  EXPECT_EQ(worst.bits_within(kLimit, kUnknown), 500u);
  worst.learn(1000, 30ms, kTelling);
  const auto spend = [&](Nanoseconds time) {
    for (Nanoseconds spent{}; spent < time; spent += 5ms) worst.learn(1 << 20, 5ms, kTelling);
  };
  spend(WorstRate::kRemembered);
  worst.learn(1000, 40ms, kTelling);
  EXPECT_LE(worst.bits_within(kLimit, kUnknown), 500u) << "of two times, one counts with the other";
  spend(2 * WorstRate::kRemembered);
  EXPECT_EQ(worst.bits_within(kLimit, kUnknown), kUnknown) << "what cost 5 ns a bit of late";
}

}  // namespace
}  // namespace gnomon::scheduler
