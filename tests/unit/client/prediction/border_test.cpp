// The prediction border by side: the picture's pixels are the same wherever it lies, and more of it lies where the
// camera turns to.
#include "client/prediction/border.h"

#include <gtest/gtest.h>

#include <cmath>

#include "client/prediction/motion.h"

namespace gnomon::client {
namespace {

constexpr ViewSize kSize{.width = 320, .height = 180, .border_x = 64, .border_y = 36};

scenes::CameraPose looking(float yaw, float pitch = 0) {
  scenes::CameraPose pose;
  pose.vertical_fov = 0.9f;
  pose.orientation = glm::angleAxis(yaw, glm::vec3(0, 1, 0)) * glm::angleAxis(pitch, glm::vec3(1, 0, 0));
  return pose;
}

TEST(Border, EveryPlaceShowsTheSamePixels) {
  const protocol::CameraView plain = view_of(looking(0), {.width = 320, .height = 180});
  for (const BorderPlace place : {BorderPlace{32, 18}, {0, 0}, {64, 36}, {50, 3}}) {
    const protocol::CameraView traced = view_of(looking(0), kSize, place);
    EXPECT_EQ(place_of(traced, kSize), place);
    const protocol::CameraView shown = shown_part(traced, kSize);
    EXPECT_NEAR(shown.tan_left, plain.tan_left, 1e-6f);
    EXPECT_NEAR(shown.tan_right, plain.tan_right, 1e-6f);
    EXPECT_NEAR(shown.tan_up, plain.tan_up, 1e-6f);
    EXPECT_NEAR(shown.tan_down, plain.tan_down, 1e-6f);
    // All pixels have the same size.
    EXPECT_NEAR((traced.tan_left + traced.tan_right) / 384, (plain.tan_left + plain.tan_right) / 320, 1e-8f);
    EXPECT_TRUE(protocol::is_valid(traced));
  }
}

TEST(Border, LiesWhereTheCameraTurnsTo) {
  EXPECT_EQ(towards(kSize, looking(0), looking(0)), centred(kSize));
  const BorderPlace left = towards(kSize, looking(0), looking(0.1f)),
                    right = towards(kSize, looking(0), looking(-0.1f));
  EXPECT_GT(left.left, 32u);
  EXPECT_LT(right.left, 32u);
  EXPECT_EQ(left.left + right.left, 64u);
  EXPECT_GT(towards(kSize, looking(0), looking(0, 0.05f)).top, 18u);
  EXPECT_LT(towards(kSize, looking(0), looking(0, -0.05f)).top, 18u);
  EXPECT_EQ(towards(kSize, looking(0), looking(3)), centred(kSize));
  EXPECT_EQ(towards(kSize, looking(0), looking(1)).left, 64u);
}

TEST(Border, LeavesLessUnseenOnThatSide) {
  const auto unseen = [](BorderPlace place) {
    return motion_between(view_of(looking(0), kSize, place), view_of(looking(0.15f), kSize), kSize, 4).unseen;
  };
  EXPECT_LT(unseen(towards(kSize, looking(0), looking(0.15f))), unseen(centred(kSize)));
}

TEST(Extrapolate, GoesOnAsBefore) {
  scenes::CameraPose before = looking(0.1f), now = looking(0.15f);
  now.position = {1, 0, 0.5f};
  const scenes::CameraPose then = extrapolate(before, now, 3);
  EXPECT_NEAR(glm::distance(then.position, glm::vec3(4, 0, 2)), 0, 1e-5f);
  EXPECT_NEAR(std::abs(glm::dot(then.orientation, looking(0.30f).orientation)), 1, 1e-5f);
  EXPECT_EQ(extrapolate(now, now, 7).position, now.position);
}

TEST(ImageMotion, TellsTurningFromMoving) {
  const protocol::CameraView rest = view_of(looking(0), kSize);
  const ImageMotion none = motion_between(rest, rest, kSize, 4);
  EXPECT_EQ(none.unseen, 0);
  EXPECT_NEAR(none.turn + none.shift, 0, 1e-5);
  const ImageMotion turned = motion_between(rest, view_of(looking(0.05f), kSize), kSize, 4);
  EXPECT_GT(turned.turn, 0.02);
  EXPECT_NEAR(turned.shift, 0, 1e-5);
  scenes::CameraPose aside = looking(0);
  aside.position = {0.2f, 0, 0};
  const ImageMotion moved = motion_between(rest, view_of(aside, kSize), kSize, 4);
  EXPECT_NEAR(moved.turn, 0, 1e-5);
  EXPECT_NEAR(moved.shift, 0.2 / 4 / (2 * std::tan(0.45) * 16 / 9), 1e-3);
  EXPECT_EQ(motion_between(rest, view_of(looking(3.1f), kSize), kSize, 4).unseen, 1);
}

}  // namespace
}  // namespace gnomon::client
