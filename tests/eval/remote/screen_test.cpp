#include "tests/eval/remote/screen.h"

#include <gtest/gtest.h>

namespace gnomon::remote {
namespace {

using namespace std::chrono_literals;

// Ten steps a second, pictures 150 ms after their cameras: one step old at each end of a step, none at that of step 0.
Screen flown(uint32_t steps) {
  Screen screen{.started = TimePoint{} + 1h, .rate_hz = 10, .steps = steps, .pictures = {}};
  for (uint32_t step = 0; step < steps; ++step)
    screen.pictures.push_back({step, screen.started + step * 100ms + 150ms, {}});
  return screen;
}

TEST(Screen, APictureInTimeIsJudgedByItsOwnCamera) {
  const auto seen = seen_at_steps(flown(20), 5);
  ASSERT_EQ(seen.size(), 15u);
  for (size_t i = 0; i < seen.size(); ++i) {
    EXPECT_EQ(seen[i].picture, i + 4);
    EXPECT_EQ(seen[i].meant, i + 4);
    EXPECT_FALSE(seen[i].late);
  }
}

TEST(Screen, PicturesThatNeverCameLeaveOldOnesWhichAreJudgedByThoseMeant) {
  Screen screen = flown(20);
  screen.pictures.erase(screen.pictures.begin() + 10, screen.pictures.begin() + 13);  // those of steps 10 to 12
  const auto seen = seen_at_steps(screen, 0);
  ASSERT_EQ(seen.size(), 19u);    // none at step 0
  EXPECT_EQ(seen[10].meant, 9u);  // at the end of step 11: one step older than usual
  EXPECT_FALSE(seen[10].late);
  for (const size_t step : {12, 13}) {
    const Seen& held = seen[step - 1];
    EXPECT_EQ(screen.pictures[held.picture].step, 9u);
    EXPECT_TRUE(held.late);
    EXPECT_EQ(held.meant, step - 1);  // the camera that is usually on the screen then
  }
  EXPECT_FALSE(seen[13].late);
}

TEST(Screen, WithoutPicturesNothingIsJudged) {
  EXPECT_TRUE(seen_at_steps({.started = {}, .rate_hz = 30, .steps = 9, .pictures = {}}, 0).empty());
}

}  // namespace
}  // namespace gnomon::remote
