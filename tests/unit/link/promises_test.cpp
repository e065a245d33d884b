// The protocol's promises for bad links, with the sender, the client's parts and simulated links in virtual time.
#include <gtest/gtest.h>

#include "tests/unit/link/scenarios.h"

namespace gnomon::tests {
namespace {

using namespace std::chrono_literals;

class Promise : public testing::TestWithParam<uint64_t> {};

TEST_P(Promise, FivePercentLossLeavesTilesFresh) {
  for (const Nanoseconds delay : {2ms, 25ms, 60ms}) {
    const LossFigures figures = random_loss(GetParam(), delay);
    EXPECT_GE(figures.fresh_share, 0.99) << to_milliseconds(delay);
    EXPECT_LE(figures.longest_gap, 200ms) << "no stall";
    EXPECT_GT(figures.retransmitted + figures.recovered, 0u);
  }
}

TEST_P(Promise, BurstsOfLossesDoSo) {
  const LossFigures figures = bursty_loss(GetParam());
  EXPECT_GE(figures.fresh_share, 0.99);
  EXPECT_LE(figures.longest_gap, 200ms);
}

TEST_P(Promise, HeavyLossesAreOverASecondAfterTheirEnd) {
  const LossFigures figures = heavy_loss(GetParam());
  EXPECT_LE(figures.recovery, 1s);
  EXPECT_GE(figures.fresh_share, 0.8) << "and meanwhile it goes on";
}

TEST_P(Promise, ABottleneckIsUsedAndItsQueueKeptShort) {
  const QueueFigures figures = bottleneck(GetParam());
  EXPECT_LE(figures.wait_p95, 20ms);
  EXPECT_LE(figures.wait_max, 30ms);
  EXPECT_GE(figures.used_share, 0.8);
}

TEST_P(Promise, ASessionThatStartsKeepsItShortToo) {
  for (const Nanoseconds delay : {5ms, 25ms}) {
    const QueueFigures figures = bottleneck(GetParam(), true, delay);
    EXPECT_LE(figures.wait_max, 20ms) << to_milliseconds(delay);
    EXPECT_GE(figures.used_share, 0.8) << to_milliseconds(delay);
  }
}

TEST_P(Promise, SessionsShareEvenly) {
  const Shares shares = sharing(GetParam(), 2, false);
  for (const double share : shares.sessions) EXPECT_NEAR(share, 0.5, 0.1);
  EXPECT_LE(shares.wait_p95, 20ms);
}

TEST_P(Promise, NobodyStarvesBesideTcp) {
  const Shares shares = sharing(GetParam(), 2, true);
  for (const double share : shares.sessions) EXPECT_GE(share, 0.15) << "a third would be even";
  EXPECT_GE(shares.tcp, 0.15);
}

TEST_P(Promise, APathThatTakesShorterDatagramsThanBeforeIsFoundOut) {
  const MtuFigures figures = narrowing_path(GetParam());
  EXPECT_EQ(figures.found, 1472u);
  EXPECT_LE(figures.after, 1300u);
  EXPECT_LE(figures.longest_gap, 1s);
  EXPECT_EQ(figures.fresh_share, 1);
}

INSTANTIATE_TEST_SUITE_P(Seeds, Promise, testing::Values(1, 2, 3));

}  // namespace
}  // namespace gnomon::tests
