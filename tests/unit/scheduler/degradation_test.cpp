#include "scheduler/degradation.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gnomon::scheduler {
namespace {

constexpr double kRate = 60;  // views a window

// A session that needs `load` of a device at the granted rate and size; the device gives it `room`.
struct Session {
  Degradation degradation;
  uint32_t changes = 0;

  double need(double load) const {
    const OperatingPoint p = degradation.point();
    return load * p.rate * p.size * p.size;
  }
  void run(uint32_t windows, double load, double room) {
    for (uint32_t i = 0; i < windows; ++i) {
      const double offered = kRate * degradation.point().rate;
      const double answered = offered * std::min(1.0, room / need(load));
      changes += degradation.observe({static_cast<uint32_t>(offered), static_cast<uint32_t>(answered)});
    }
  }
};

Session session(double least_rate, double least_size) {
  return {Degradation({.least_rate = least_rate, .least_size = least_size}), 0};
}

TEST(Degradation, NothingChangesWhileAllIsWell) {
  Session s = session(0.25, 0.5);
  s.run(1000, 0.9, 1);
  EXPECT_EQ(s.changes, 0u);
  EXPECT_EQ(s.degradation.point(), OperatingPoint{});
}

TEST(Degradation, OneBadWindowIsForgiven) {
  Session s = session(0.25, 0.5);
  for (int i = 0; i < 100; ++i) {
    s.run(1, 10, 1);
    s.run(1, 0.5, 1);
  }
  EXPECT_EQ(s.changes, 0u);
}

TEST(Degradation, TwoBadWindowsInARowAreOneStepDown) {
  Session s = session(0.25, 0.5);
  s.run(1, 10, 1);
  EXPECT_EQ(s.degradation.point(), OperatingPoint{});
  s.run(1, 10, 1);
  EXPECT_EQ(s.degradation.point(), (OperatingPoint{.rate = 0.75}));
}

TEST(Degradation, TheRateGoesFirstThenTheSizeAndNeitherTooFar) {
  Session s = session(0.5, 0.5);
  OperatingPoint before = s.degradation.point();
  for (int i = 0; i < 50; ++i) {
    s.run(2, 1000, 1);
    const OperatingPoint now = s.degradation.point();
    EXPECT_LE(now.rate, before.rate);
    EXPECT_LE(now.size, before.size);
    if (now.size < before.size) {
      EXPECT_LT(now.rate * 0.75, 0.5) << "the rate had gone as far as it may";
    }
    before = now;
  }
  EXPECT_GE(before.rate, 0.5);
  EXPECT_GE(before.size, 0.5);
  EXPECT_LT(before.rate * before.size, 0.5);
}

TEST(Degradation, SamplesGoAfterTheRateAndBeforeTheSize) {
  for (const uint32_t least : {1u, 4u, 16u}) {
    Session s = session(0.5, 0.5);
    s.degradation.set_limits({.least_rate = 0.5, .least_size = 0.5, .least_samples = least}, 16);
    const uint32_t steps = least == 1 ? 2 : least == 4 ? 1 : 0;
    for (int i = 0; i < 50; ++i) {
      s.run(2, 1e6, 1);
      const OperatingPoint now = s.degradation.point();
      if (now.fewer_samples > 0) {
        EXPECT_LT(now.rate * 0.75, 0.5) << "the rate had gone as far as it may";
      }
      if (now.size < 1) {
        EXPECT_EQ(now.fewer_samples, steps) << "and so had the samples";
      }
    }
    EXPECT_EQ(s.degradation.point().fewer_samples, steps);
    EXPECT_LT(s.degradation.point().size, 1);
    s.run(500, 0.1, 1);
    EXPECT_EQ(s.degradation.point(), OperatingPoint{});
  }
}

TEST(Degradation, OcclusionGoesAfterThePointsOfLights) {
  Session s = session(0.5, 0.5);
  s.degradation.set_limits({.least_rate = 0.5, .least_size = 0.5, .least_samples = 4}, {16, Occlusion::full});
  std::vector<SampleCounts> seen{s.degradation.samples()};
  for (int i = 0; i < 50; ++i) {
    s.run(2, 1e6, 1);
    if (s.degradation.samples() != seen.back()) seen.push_back(s.degradation.samples());
    if (s.degradation.point().size < 1) {
      EXPECT_EQ(s.degradation.samples(), (SampleCounts{4, Occlusion::none}));
    }
  }
  EXPECT_EQ(seen, (std::vector<SampleCounts>{
                      {16, Occlusion::full}, {4, Occlusion::full}, {4, Occlusion::half}, {4, Occlusion::none}}));
  s.run(500, 0.1, 1);
  EXPECT_EQ(s.degradation.samples(), (SampleCounts{16, Occlusion::full}));
}

TEST(Degradation, HardShadowsHaveNoSamplesToLose) {
  Session s = session(1, 1);
  s.run(100, 10, 1);
  EXPECT_EQ(s.degradation.point().fewer_samples, 0u);
}

TEST(Degradation, LightsGoLast) {
  Session s{Degradation({.least_rate = 0.5, .least_size = 0.5, .least_lights = 0.25}), 0};
  for (int i = 0; i < 50; ++i) {
    s.run(2, 1e6, 1);
    if (s.degradation.point().lights < 1) {
      EXPECT_LT(s.degradation.point().size * 0.75, 0.5);
    }
  }
  EXPECT_GE(s.degradation.point().lights, 0.25);
  EXPECT_LT(s.degradation.point().lights, 0.34);
  s.run(500, 0.1, 1);
  EXPECT_EQ(s.degradation.point(), OperatingPoint{});
}

TEST(Degradation, WhoMayNotBeDegradedIsNot) {
  Session s = session(1, 1);
  s.run(100, 10, 1);
  EXPECT_EQ(s.changes, 0u);
}

TEST(Degradation, RecoversWhenTheLoadFalls) {
  Session s = session(0.25, 0.5);
  s.run(50, 5, 1);
  EXPECT_LT(s.degradation.point().rate, 1);
  s.run(1000, 0.5, 1);
  EXPECT_EQ(s.degradation.point(), OperatingPoint{});
}

// A steady overload leads to steps down, and then to attempts to step up that become ever rarer.
TEST(Degradation, StepsBeyondTighterLimitsNeedNotBeTakenBack) {
  Session s = session(0.25, 0.5);
  s.run(60, 100, 1);
  s.degradation.set_limits({.least_rate = 0.75, .least_size = 1});
  ASSERT_EQ(s.degradation.point().rate, 0.75);
  s.changes = 0;
  s.run(10, 0.5, 1);
  EXPECT_EQ(s.changes, 1u);
  EXPECT_EQ(s.degradation.point(), OperatingPoint{});
}

TEST(Degradation, ASteadyOverloadSettles) {
  Session s = session(0.25, 0.5);
  s.run(100, 2, 1);
  const uint32_t settling = s.changes;
  s.changes = 0;
  s.run(1000, 2, 1);
  EXPECT_LE(s.changes, 16u) << settling << " while it settled";
  EXPECT_LE(s.need(2), 1 / 0.75 + 1e-9) << "at most the one step too high that is being tried";
}

TEST(Degradation, WindowsWithoutViewsTellNothing) {
  Session s = session(0.25, 0.5);
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(s.degradation.observe({3, 0}));
}

}  // namespace
}  // namespace gnomon::scheduler
