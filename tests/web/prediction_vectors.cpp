// Prints what the native client's prediction says of random cameras, one JSON object in each line, for the page's tests to
// compare with: tests/web/prediction_test.mjs.
#include <cstdio>
#include <random>

#include "client/prediction/border.h"
#include "client/prediction/error_balance.h"
#include "client/prediction/motion.h"

namespace {

using namespace gnomon;
using namespace gnomon::client;

std::mt19937 random_bits(20);

float within(float least, float most) { return std::uniform_real_distribution<float>(least, most)(random_bits); }

scenes::CameraPose random_pose(const scenes::CameraPose& near, float reach) {
  scenes::CameraPose pose = near;
  pose.position += glm::vec3(within(-1, 1), within(-1, 1), within(-1, 1)) * reach;
  const glm::vec3 axis =
      glm::normalize(glm::vec3(within(-1, 1), within(-1, 1), within(-1, 1)) + glm::vec3(0, 1e-3f, 0));
  pose.orientation = glm::normalize(glm::angleAxis(within(-0.3f, 0.3f) * reach, axis) * near.orientation);
  return pose;
}

void print(const char* name, const scenes::CameraPose& pose) {
  std::printf("\"%s\":{\"position\":[%.9g,%.9g,%.9g],\"orientation\":[%.9g,%.9g,%.9g,%.9g],\"verticalFov\":%.9g},",
              name, pose.position.x, pose.position.y, pose.position.z, pose.orientation.x, pose.orientation.y,
              pose.orientation.z, pose.orientation.w, pose.vertical_fov);
}

void print(const char* name, const protocol::CameraView& view) {
  std::printf("\"%s\":[%.9g,%.9g,%.9g,%.9g],", name, view.tan_left, view.tan_right, view.tan_up, view.tan_down);
}

}  // namespace

int main() {
  const ViewSize size{1280, 720, 64, 48};
  ErrorCurve curve(size);
  for (int i = 0; i < 200; ++i) {
    const scenes::CameraPose before = random_pose({{1, 2, 3}, {1, 0, 0, 0}, 0.9f}, 3);
    const scenes::CameraPose now = random_pose(before, within(0, 1));
    const BorderPlace place = towards(size, before, now);
    const protocol::CameraView traced = view_of(before, size, place), later = view_of(now, size, centred(size));
    const ImageMotion motion = motion_between(traced, later, size, 4);
    const double error = std::min(1.0, 0.01 + 0.3 * motion.unseen + 0.05 * motion.turn + 0.08 * motion.shift);
    curve.learn(motion, error);
    std::printf("{");
    print("before", before);
    print("now", now);
    print("then", extrapolate(before, now, 3));
    print("traced", traced);
    print("shown", shown_part(traced, size));
    const BorderPlace again = place_of(traced, size);
    std::printf("\"place\":{\"left\":%u,\"top\":%u},\"again\":{\"left\":%u,\"top\":%u},", place.left, place.top,
                again.left, again.top);
    std::printf(
        "\"motion\":{\"unseen\":%.12g,\"turn\":%.12g,\"shift\":%.12g},\"error\":%.12g,\"expected\":%.12g}\n",
        motion.unseen, motion.turn, motion.shift, error, curve.expect(motion));
  }
}
