#include "client/prediction/switching.h"

#include <cmath>
#include <glm/gtc/quaternion.hpp>

namespace gnomon::client {
namespace {

glm::quat orientation(const protocol::CameraView& camera) {
  const auto& q = camera.orientation;
  return {q[3], q[0], q[1], q[2]};
}

double change(glm::vec3 from, glm::vec3 to) {
  const glm::vec3 d = glm::abs(to - from);
  return static_cast<double>(d.x + d.y + d.z);
}

glm::vec3 to_glm(const protocol::Vec3& v) { return {v[0], v[1], v[2]}; }

}  // namespace

double Switching::value_of(const PredictionChoice& choice) const {
  const auto& newest = choice.cameras.back().camera;
  const auto& before = choice.cameras.size() > 1 ? choice.cameras[choice.cameras.size() - 2].camera : newest;
  const glm::quat q0 = orientation(before), q1 = orientation(newest);
  const glm::vec3 up(0, 1, 0), forward(0, 0, -1);
  return options_.position * change(to_glm(before.position), to_glm(newest.position)) +
         options_.up * change(q0 * up, q1 * up) + options_.target * change(q0 * forward, q1 * forward) -
         options_.latency * to_seconds(choice.latency);
}

void Switching::decide(double value) {
  if (!sequential_) {
    sequential_ = value > options_.high;
    remain_ = sequential_ ? options_.dwell : 0;
    return;
  }
  if (remain_ > 0 && --remain_ > 0) return;
  if (value > options_.mid)
    remain_ = options_.dwell;
  else if (value < options_.low)
    sequential_ = false;
}

size_t Switching::choose(const PredictionChoice& choice) {
  decide(value_of(choice));
  return sequential_ ? choice.least : choice.most();
}

}  // namespace gnomon::client
