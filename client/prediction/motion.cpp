#include "client/prediction/motion.h"

#include <cmath>
#include <glm/gtc/quaternion.hpp>

namespace gnomon::client {
namespace {

constexpr int kPointsAcross = 12, kPointsDown = 7;  // sample points, evenly over the picture

struct Camera {
  explicit Camera(const protocol::CameraView& v)
      : view(v),
        position(v.position[0], v.position[1], v.position[2]),
        to_world(v.orientation[3], v.orientation[0], v.orientation[1], v.orientation[2]),
        from_world(glm::inverse(to_world)) {}

  const protocol::CameraView& view;
  glm::vec3 position;
  glm::quat to_world, from_world;
};

// Where the camera sees a direction, as tangents; `behind` if it does not see it.
struct Place {
  glm::vec2 tangents{0.0f};
  bool behind = false;
};

Place place(const Camera& camera, glm::vec3 direction) {
  const glm::vec3 d = camera.from_world * direction;
  if (d.z > -1e-3f * glm::length(d)) return {{}, true};
  return {{d.x / -d.z, d.y / -d.z}, false};
}

bool inside(const protocol::CameraView& view, const Place& at) {
  return !at.behind && at.tangents.x >= -view.tan_left && at.tangents.x <= view.tan_right &&
         at.tangents.y >= -view.tan_down && at.tangents.y <= view.tan_up;
}

}  // namespace

ImageMotion motion_between(const protocol::CameraView& traced, const protocol::CameraView& later,
                           const ViewSize& size, double distance) {
  const protocol::CameraView shown = shown_part(later, size);
  const Camera before(traced), after(later);
  const float width = shown.tan_left + shown.tan_right, height = shown.tan_up + shown.tan_down;
  ImageMotion motion;
  for (int j = 0; j < kPointsDown; ++j)
    for (int i = 0; i < kPointsAcross; ++i) {
      const glm::vec3 ray(-shown.tan_left + width * (static_cast<float>(i) + 0.5f) / kPointsAcross,
                          shown.tan_up - height * (static_cast<float>(j) + 0.5f) / kPointsDown, -1.0f);
      const glm::vec3 direction = after.to_world * ray;
      const glm::vec3 point = after.position + static_cast<float>(distance) * direction;
      const Place turned = place(before, direction), moved = place(before, point - before.position);
      if (!inside(traced, moved)) {
        motion.unseen += 1;
        continue;
      }
      if (turned.behind) continue;
      motion.turn += static_cast<double>(glm::distance(turned.tangents, glm::vec2(ray)) / width);
      motion.shift += static_cast<double>(glm::distance(turned.tangents, moved.tangents) / width);
    }
  constexpr double kPoints = kPointsAcross * kPointsDown;
  return {motion.unseen / kPoints, motion.turn / kPoints, motion.shift / kPoints};
}

}  // namespace gnomon::client
