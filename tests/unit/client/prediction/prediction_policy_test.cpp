// The policies that choose x: the dissertation's thresholds and dwell time, and ours.
#include "client/prediction/prediction_policy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "client/prediction/error_balance.h"
#include "client/prediction/switching.h"

namespace gnomon::client {
namespace {

using namespace std::chrono_literals;

constexpr ViewSize kSize{.width = 320, .height = 180, .border_x = 16, .border_y = 8};
constexpr Nanoseconds kFrame = 16ms;

// `count` cameras, each turned by `step` from the one before it.
std::deque<RequestedCamera> turning(size_t count, float step) {
  std::deque<RequestedCamera> cameras;
  for (size_t i = 0; i < count; ++i) {
    scenes::CameraPose pose;
    pose.vertical_fov = 0.9f;
    pose.orientation = glm::angleAxis(step * static_cast<float>(i), glm::vec3(0, 1, 0));
    cameras.push_back({static_cast<uint32_t>(i), view_of(pose, kSize), TimePoint{} + i * kFrame});
  }
  return cameras;
}

size_t choose(PredictionPolicy& ahead, const std::deque<RequestedCamera>& cameras, size_t least = 0,
              Nanoseconds latency = 50ms) {
  return ahead.choose({cameras, least, latency, cameras.back().asked});
}

TEST(FixedPrediction, IsLimitedByWhatThereIs) {
  FixedPrediction four(4);
  EXPECT_EQ(choose(four, turning(10, 0)), 4u);
  EXPECT_EQ(choose(four, turning(3, 0)), 2u);
  EXPECT_EQ(choose(four, turning(10, 0), 7), 7u);
  FixedPrediction all(1000);
  EXPECT_EQ(choose(all, turning(50, 0)), kMostAhead);
}

TEST(Switching, IsSequentialWhileTheCameraIsSharpAndAWhileAfter) {
  SwitchingOptions options;
  options.position = 0;
  options.up = 0;
  options.target = 1;
  options.latency = 0;
  options.high = 0.10;
  options.mid = 0.06;
  options.low = 0.02;
  options.dwell = 5;
  Switching switching(options);
  const auto still = turning(10, 0), between = turning(10, 0.04f), brisk = turning(10, 0.065f),
             sharp = turning(10, 0.2f);
  EXPECT_EQ(choose(switching, brisk), 9u) << "not above high: not sequential";
  EXPECT_EQ(choose(switching, sharp), 0u);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(choose(switching, still), 0u) << "dwells";
  EXPECT_EQ(choose(switching, still), 9u) << "below low: back at once";
  choose(switching, sharp);
  for (int i = 0; i < 5; ++i) choose(switching, brisk);
  EXPECT_EQ(choose(switching, still), 0u) << "above mid: dwells once more";
  for (int i = 0; i < 4; ++i) choose(switching, between);
  for (int i = 0; i < 9; ++i) EXPECT_EQ(choose(switching, between), 0u) << "between low and mid: stays, watching";
  EXPECT_EQ(choose(switching, still), 9u);
}

TEST(Switching, LatencySpeaksAgainstSequential) {
  SwitchingOptions options;
  options.target = 1;
  options.up = options.position = 0;
  options.latency = 1;
  options.high = 0.05;
  Switching near(options), far(options);
  EXPECT_EQ(choose(near, turning(10, 0.08f), 0, 5ms), 0u);
  EXPECT_EQ(choose(far, turning(10, 0.08f), 0, 200ms), 9u);
}

TEST(ErrorBalance, ShowsTheNewestWhileTheCameraRests) {
  ErrorBalance balance({.size = kSize});
  EXPECT_EQ(choose(balance, turning(10, 0)), 9u);
}

TEST(ErrorBalance, GoesLessFarTheMoreItCosts) {
  const auto chosen = [](float step, double cost_per_s) {
    ErrorBalance balance({.size = kSize, .cost_per_s = cost_per_s});
    return choose(balance, turning(15, step));
  };
  EXPECT_EQ(chosen(0.05f, 0), 0u) << "time costs nothing";
  EXPECT_EQ(chosen(0.05f, 1000), 14u) << "errors cost nothing";
  EXPECT_LE(chosen(0.1f, 0.3), chosen(0.01f, 0.3));
  EXPECT_LE(chosen(0.05f, 0.1), chosen(0.05f, 1.0));
}

TEST(ErrorBalance, NeverGoesBack) {
  ErrorBalance balance({.size = kSize, .cost_per_s = 0});
  EXPECT_EQ(choose(balance, turning(15, 0.1f), 6), 6u);
}

// A scene in which motion costs several times what was assumed, which is learned from the errors of predictions.
TEST(ErrorCurve, LearnsWhatPredictionsTurnOutToBe) {
  ErrorCurve curve(kSize);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(0, 1);
  const auto truth = [](const ImageMotion& m) { return 0.01 + 0.4 * m.unseen + 0.2 * m.turn + 0.3 * m.shift; };
  const auto motion = [&] { return ImageMotion{any(random) * 0.2, any(random) * 0.1, any(random) * 0.05}; };
  const auto worst = [&] {
    double most = 0;
    for (int i = 0; i < 100; ++i) {
      const ImageMotion m = motion();
      most = std::max(most, std::abs(curve.expect(m) - truth(m)));
    }
    return most;
  };
  const double before = worst();
  for (int i = 0; i < 300; ++i) {
    const ImageMotion m = motion();
    curve.learn(m, truth(m) * (0.9 + 0.2 * any(random)));
  }
  EXPECT_LT(worst(), 0.3 * before);
  const double learned = curve.expect({0.1, 0.05, 0.02});
  for (int i = 0; i < 100'000; ++i) curve.learn({}, 0);
  EXPECT_EQ(curve.expect({0.1, 0.05, 0.02}), learned) << "a camera that rests teaches nothing";
  EXPECT_EQ(curve.expect({}), 0);
}

}  // namespace
}  // namespace gnomon::client
