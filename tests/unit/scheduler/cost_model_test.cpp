#include "scheduler/cost_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace gnomon::scheduler {
namespace {

// A device of known costs, with some noise and occasional frames that were delayed.
class Device {
 public:
  explicit Device(double noise, double held_up = 0) : noise_(noise), held_up_(held_up) {}

  double begin_ns = 300'000, ns_per_pixel = 0.5, ns_per_bit = 0.2;

  double trace_ns(const Work& work) const { return ns_per_bit * static_cast<double>(work.bits); }
  double cost_ns(const Work& work) const {
    return (work.begins ? begin_ns + ns_per_pixel * static_cast<double>(work.pixels) : 0) + trace_ns(work);
  }

  void run(CostModel& model, const Work& work) {
    const double factor = 1 + noise_ * std::uniform_real_distribution<>(-1, 1)(random_);
    const double stall = std::bernoulli_distribution(held_up_)(random_) ? 50e6 : 0;
    model.learn(work, ns(cost_ns(work) * factor + stall), ns(trace_ns(work) * factor + stall));
  }

  Work any_frame() {
    const uint64_t pixels = 64'000 << (random_() % 5);
    return {pixels, pixels * 8, true};
  }

 private:
  static Nanoseconds ns(double value) { return Nanoseconds(static_cast<int64_t>(value)); }

  double noise_, held_up_;
  std::mt19937 random_{5};
};

double predicted(const CostModel& model, const Work& work) {
  return static_cast<double>(model.predict(work).total().count());
}

TEST(CostModel, GuessesBeforeItKnows) {
  const CostModel model;
  EXPECT_FALSE(model.knows());
  EXPECT_GT(predicted(model, {1000, 8000, true}), 1);
}

TEST(CostModel, LearnsASizeFromOneFrame) {
  CostModel model;
  Device device(0);
  const Work work{64'000, 512'000, true};
  device.run(model, work);
  EXPECT_NEAR(predicted(model, work) / device.cost_ns(work), 1, 1e-6);
}

TEST(CostModel, TellsTheConstantsFromThePartsThatGrow) {
  CostModel model;
  Device device(0.05);
  for (int i = 0; i < 400; ++i) device.run(model, device.any_frame());
  EXPECT_NEAR(model.ns_per_bit(), 0.2, 0.01);
  for (const uint64_t pixels : {64'000u, 500'000u, 2'000'000u}) {
    const Work frame{pixels, pixels * 8, true}, band{pixels, pixels, false};
    EXPECT_NEAR(predicted(model, frame) / device.cost_ns(frame), 1, 0.06) << pixels;
    EXPECT_NEAR(predicted(model, band) / device.cost_ns(band), 1, 0.2) << pixels;
  }
  EXPECT_LT(model.relative_error(), 0.06);
}

TEST(CostModel, TheConstantIsWhatIsNeitherForPixelsNorForBits) {
  CostModel model;
  for (uint64_t pixels = 1000; pixels <= 20'000; pixels += 1000) {
    const Work work{pixels, 8 * pixels, true};
    const Nanoseconds begin(5000 + 2 * pixels), trace(300 + work.bits);
    model.learn(work, begin + trace, trace);
  }
  EXPECT_NEAR(static_cast<double>(model.constant().count()), 5300, 10);
}

// Twice the size costs four times as much: the line that fits best would begin below 0.
TEST(CostModel, ALineIsNowhereNegative) {
  RobustLine line;
  for (const double x : {1.0, 2.0, 4.0, 8.0}) line.learn(x, x * x);
  EXPECT_GE(line.constant(), 0);
  EXPECT_GE(line.at(0.5), 0);
  EXPECT_GT(line.slope(), 0);
}

TEST(CostModel, FramesThatWereHeldUpTeachLittle) {
  CostModel model;
  Device device(0.05, 0.05);
  for (int i = 0; i < 400; ++i) device.run(model, device.any_frame());
  const Work frame{256'000, 2'048'000, true};
  EXPECT_NEAR(predicted(model, frame) / device.cost_ns(frame), 1, 0.3);
}

TEST(CostModel, ARealChangeIsLearned) {
  CostModel model;
  Device device(0.05);
  for (int i = 0; i < 400; ++i) device.run(model, device.any_frame());
  device.ns_per_bit *= 3;
  for (int i = 0; i < 200; ++i) device.run(model, device.any_frame());
  const Work frame{256'000, 2'048'000, true};
  EXPECT_NEAR(predicted(model, frame) / device.cost_ns(frame), 1, 0.1);
}

TEST(CostModel, NeverPredictsLessThanNothing) {
  CostModel model;
  std::mt19937 random(9);
  for (int i = 0; i < 10'000; ++i) {
    const Work work{random() % 5'000'000, random() % 50'000'000, random() % 2 == 0};
    const auto trace = Nanoseconds(random() % 10'000'000);
    model.learn(work, trace + Nanoseconds(random() % 10'000'000), trace);
    ASSERT_GE(model.predict({random() % 5'000'000, random() % 50'000'000, true}).total().count(), 0);
  }
}

TEST(CostModel, AnotherSizeIsLearnedFromItsFirstFrame) {
  CostModel model;
  Device device(0.05);
  device.begin_ns = 5e6;
  const Work small{15'000, 45'000, true}, large{230'000, 690'000, true};
  for (int i = 0; i < 400; ++i) device.run(model, small);
  EXPECT_GT(predicted(model, large) / device.cost_ns(large), 5) << "a line through the origin, for want of better";
  device.run(model, large);
  EXPECT_NEAR(predicted(model, large) / device.cost_ns(large), 1, 0.15);
  EXPECT_NEAR(predicted(model, small) / device.cost_ns(small), 1, 0.15);
}

// One session of tiny frames must not make the device look full to everybody.
TEST(CostModel, TinyFramesSayNothingOfLargeOnes) {
  CostModel model;
  const Work tiny{64, 192, true}, large{1920 * 1080, 1920 * 1080 * 3, true};
  for (int i = 0; i < 100; ++i) model.learn({160 * 90, 160 * 90 * 3, true}, 3ms, 2ms);  // and is soon forgotten
  for (int i = 0; i < 1000; ++i) {
    model.learn(tiny, 2ms, 1ms);
    model.learn_bytes(tiny.bits, 100);
  }
  EXPECT_LE(model.predict_within_reach(large).total(), 20ms);
  EXPECT_GE(model.predict_within_reach(large).total(), 2ms);
  EXPECT_GE(model.predict(large).total(), 1s) << "so that it is cut";
  EXPECT_EQ(model.predict_bytes(large.bits), 0) << "unknown";
  model.learn(large, 40ms, 30ms);
  model.learn_bytes(large.bits, 60'000);
  EXPECT_NEAR(to_milliseconds(model.predict_within_reach(large).total()), 40, 4);
  EXPECT_NEAR(model.predict_bytes(large.bits), 60'000, 600);
}

TEST(ViewFactor, FollowsASessionsOwnViewInBothParts) {
  using std::chrono::nanoseconds;
  ViewFactor view;
  const Cost model{nanoseconds(3000), nanoseconds(1000)};
  for (int i = 0; i < 20; ++i) view.learn(model, {nanoseconds(1500), nanoseconds(1700)});
  for (int i = 0; i < 20; ++i) view.learn({nanoseconds(0), nanoseconds(1000)}, {nanoseconds(0), nanoseconds(1700)});
  EXPECT_NEAR(static_cast<double>(view.apply(model).count()), 3200, 20);
  EXPECT_NEAR(static_cast<double>(view.apply({nanoseconds(0), nanoseconds(1000)}).count()), 1700, 10);
  view.learn(model, {nanoseconds(1500), nanoseconds(1'000'000)});
  EXPECT_LT(view.apply(model).count(), 4500) << "one frame that was held up";
}

}  // namespace
}  // namespace gnomon::scheduler
