#include "scheduler/sample_costs.h"

#include <gtest/gtest.h>

namespace gnomon::scheduler {
namespace {

using namespace std::chrono_literals;

// A frame of 1,000 pixels and two lights, one of them an area light.
Work frame(SampleCounts samples) { return {1000, weighted_bits(1000, 2, 1, samples), true}; }

void learn(SampleCosts& costs, SampleCounts samples, Nanoseconds cost) {
  for (int i = 0; i < 50; ++i) costs.of(samples).learn(frame(samples), cost, cost);
}

// In nanoseconds, to the nearest ten.
int64_t predicted(const SampleCosts& costs, SampleCounts samples) {
  return (costs.model(samples).predict(frame(samples)).total().count() + 5) / 10 * 10;
}

TEST(SampleCosts, AreaLightsCountAsLessThanTheirSamples) {
  EXPECT_EQ(weighted_bits(1000, 2, 0, 16), 2000u);
  EXPECT_EQ(weighted_bits(1000, 2, 1, 1), 2000u);
  EXPECT_EQ(weighted_bits(1000, 2, 1, 4), 2500u);
  EXPECT_EQ(weighted_bits(1000, 2, 2, 16), 5000u);
}

TEST(SampleCosts, OcclusionCountsAsAFewLights) {
  EXPECT_EQ(weighted_bits(1000, 2, 0, {1, Occlusion::half}), 3000u);
  EXPECT_EQ(weighted_bits(1000, 2, 1, {16, Occlusion::full}), 6500u);
}

TEST(SampleCosts, OcclusionHasCostsOfItsOwn) {
  SampleCosts costs;
  learn(costs, 1, 2000ns);
  EXPECT_EQ(predicted(costs, {1, Occlusion::full}), 5000) << "as its weight foretells";
  learn(costs, {1, Occlusion::full}, 3000ns);
  EXPECT_EQ(predicted(costs, {1, Occlusion::full}), 3000);
  EXPECT_EQ(predicted(costs, {1, Occlusion::half}), 3000)
      << "from the next fewer that is known: of 1,000 ns a light";
  EXPECT_EQ(predicted(costs, 1), 2000);
}

TEST(SampleCosts, HardShadowsForetellSoftOnesUntilTheseAreMeasured) {
  SampleCosts costs;
  learn(costs, 1, 2000ns);
  EXPECT_EQ(predicted(costs, 4), 2500);
  EXPECT_EQ(predicted(costs, 16), 3500);
  learn(costs, 4, 6000ns);
  EXPECT_EQ(predicted(costs, 4), 6000);
  EXPECT_EQ(predicted(costs, 16), 8400) << "from the nearest that is known";
  learn(costs, 16, 9000ns);
  EXPECT_EQ(predicted(costs, 16), 9000);
  EXPECT_EQ(predicted(costs, 1), 2000) << "of their own";
}

TEST(SampleCosts, SoftShadowsForetellHardOnesToo) {
  SampleCosts costs;
  EXPECT_FALSE(costs.model(16).knows());
  learn(costs, 16, 3500ns);
  EXPECT_EQ(predicted(costs, 1), 2000);
}

}  // namespace
}  // namespace gnomon::scheduler
