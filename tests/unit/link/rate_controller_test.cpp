#include "daemon/link/rate_controller.h"

#include <gtest/gtest.h>

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

class RateControllerTest : public testing::Test {
 protected:
  // Reports every 10 ms for `time`.
  void run(Nanoseconds time, PathReport report) {
    for (const TimePoint end = now_ + time; now_ < end; now_ += 10ms) {
      if (report.delivered == 0) report.delivered = rate_.rate();
      rate_.observe(report, now_);
    }
  }

  static PathReport clear() { return {.rtt = 50ms, .arrived = 10, .limited = true}; }
  static PathReport queued(Nanoseconds queue) {
    return {.rtt = 50ms + queue, .queue = queue, .delivered = 1e6, .arrived = 10, .limited = true};
  }

  RateController rate_;
  TimePoint now_{1s};
};

TEST_F(RateControllerTest, GrowsQuicklyAtFirst) {
  run(1s, clear());
  EXPECT_GT(rate_.rate(), 10 * RateController::kFirstRate);
}

TEST_F(RateControllerTest, TheFirstSignOfAQueueEndsTheStart) {
  run(1s, clear());
  run(10ms, queued(3ms));
  const double then = rate_.rate();
  EXPECT_LT(then, 1e6) << "below what is delivered";
  run(500ms, clear());
  EXPECT_LT(rate_.rate(), 2 * then) << "and no more in leaps";
  run(10ms, queued(3ms));
  EXPECT_GT(rate_.rate(), then) << "later so little is no matter";
}

TEST_F(RateControllerTest, AtTheStartItWaitsWhileAQueueMayBeBeginning) {
  run(200ms, clear());
  const double then = rate_.rate();
  run(200ms, queued(1500us));
  EXPECT_EQ(rate_.rate(), then);
  run(200ms, clear());
  EXPECT_GT(rate_.rate(), 2 * then);
}

TEST_F(RateControllerTest, DoesNotGrowUnused) {
  PathReport idle = clear();
  idle.limited = false;
  run(10s, idle);
  EXPECT_EQ(rate_.rate(), RateController::kFirstRate);
}

TEST_F(RateControllerTest, AQueueMakesItFallBelowWhatIsDelivered) {
  run(1s, clear());
  run(10ms, queued(15ms));
  EXPECT_LT(rate_.rate(), 1e6);
  EXPECT_GE(rate_.rate(), 0.3e6);
}

TEST_F(RateControllerTest, AFallIsGivenARoundTripToShow) {
  run(1s, clear());
  run(10ms, queued(15ms));
  const double then = rate_.rate();
  run(50ms, queued(16ms));
  EXPECT_EQ(rate_.rate(), then);
  run(50ms, queued(16ms));
  EXPECT_LT(rate_.rate(), then);
}

TEST_F(RateControllerTest, WhenTheQueueIsGoneItTakesUpWhatWasDelivered) {
  run(1s, clear());
  run(10ms, queued(60ms));
  EXPECT_LT(rate_.rate(), 0.8e6) << "deep, so that the queue drains";
  run(100ms, clear());
  EXPECT_NEAR(rate_.rate(), 0.85e6, 0.05e6);
}

TEST_F(RateControllerTest, GrowsGentlyAfterTheFirstQueue) {
  run(1s, clear());
  run(10ms, queued(15ms));
  run(200ms, clear());
  const double before = rate_.rate();
  run(1s, clear());
  EXPECT_GT(rate_.rate(), before);
  EXPECT_LT(rate_.rate(), 3 * before);
}

TEST_F(RateControllerTest, AQueueThatDoesNotReactIsSomebodyElses) {
  run(1s, clear());
  const double before = rate_.rate();
  run(1s, queued(60ms));
  EXPECT_TRUE(rate_.competing(now_));
  EXPECT_GT(rate_.rate(), 0.5 * before) << "what was given away in vain comes back";
  run(6s, clear());
  EXPECT_FALSE(rate_.competing(now_)) << "and is tried again";
}

TEST_F(RateControllerTest, AQueueThatShrinksIsItsOwn) {
  run(1s, clear());
  for (Nanoseconds queue = 100ms; queue > RateController::kTarget; queue = queue * 3 / 4) {
    run(queue + 60ms, queued(queue));  // until the next fall
    EXPECT_FALSE(rate_.competing(now_)) << to_milliseconds(queue);
  }
}

TEST_F(RateControllerTest, WhoCompetesFallsForALossOnceInARoundTrip) {
  run(1s, clear());
  run(1s, queued(60ms));
  ASSERT_TRUE(rate_.competing(now_));
  const double then = rate_.rate();
  PathReport lossy = queued(60ms);
  lossy.lost = 1;
  run(100ms, lossy);
  EXPECT_NEAR(rate_.rate(), 0.7 * then, 0.05 * then);
  run(20ms, lossy);
  EXPECT_NEAR(rate_.rate(), 0.49 * then, 0.05 * then);
}

TEST_F(RateControllerTest, FewLossesAreThePathsOwn) {
  PathReport lossy = clear();
  lossy.lost = 1;
  lossy.arrived = 19;
  run(1s, lossy);
  EXPECT_GT(rate_.rate(), 10 * RateController::kFirstRate);
  EXPECT_NEAR(rate_.loss(), 0.05, 0.01);
}

TEST_F(RateControllerTest, ManyLossesSlowDownUnlessThatDoesNotHelp) {
  run(500ms, clear());
  const double before = rate_.rate();
  PathReport lossy = clear();
  lossy.lost = 5;
  run(200ms, lossy);
  EXPECT_LT(rate_.rate(), 0.9 * before);
  run(3s, lossy);
  EXPECT_GT(rate_.rate(), 0.9 * before) << "a bad path, not a full one";
}

TEST_F(RateControllerTest, StaysWithinItsBounds) {
  run(60s, clear());
  EXPECT_LE(rate_.rate(), RateController::kMostRate);
  PathReport stuck = queued(500ms);
  stuck.delivered = 1;
  for (int i = 0; i < 100; ++i) {
    stuck.queue -= 4ms;
    run(600ms, stuck);
    EXPECT_GE(rate_.rate(), RateController::kLeastRate);
  }
}

}  // namespace
}  // namespace gnomon::daemon
