#include "client/media/camera_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gnomon::client {
namespace {

constexpr float kOrbitShare = 0.03f;  // of the scene's size

glm::vec3 to_glm(const protocol::Vec3& v) { return {v[0], v[1], v[2]}; }

}  // namespace

CameraPath CameraPath::of_scene(const scenes::ScenePtr& scene) {
  const auto moving = std::find_if(scene->paths.begin(), scene->paths.end(),
                                   [](const scenes::CameraPath& p) { return p.duration_seconds > 0; });
  if (moving == scene->paths.end()) {
    return {scenes::kOrbitSeconds,
            [scene](double seconds) { return scenes::orbit_pose(*scene, static_cast<float>(seconds)); }};
  }
  const float fov = scene->cameras[moving->camera].rest.vertical_fov;
  return {moving->duration_seconds, [scene, fov, path = &*moving](double seconds) {
            return scenes::pose_at(*path, fov, static_cast<float>(seconds));
          }};
}

CameraPath CameraPath::orbit(const protocol::SceneManifest& scene) {
  const protocol::CameraView& camera = scene.default_camera;
  const protocol::Quat& q = camera.orientation;
  const scenes::CameraPose rest{to_glm(camera.position), glm::quat(q[3], q[0], q[1], q[2]),
                                std::atan(camera.tan_up) + std::atan(camera.tan_down)};
  const glm::vec3 radii = kOrbitShare * (to_glm(scene.bounds_max) - to_glm(scene.bounds_min));
  return {scenes::kOrbitSeconds, [rest, radii](double seconds) {
            const auto angle = static_cast<float>(2 * std::numbers::pi * seconds / scenes::kOrbitSeconds);
            scenes::CameraPose pose = rest;
            pose.position += radii * glm::vec3(std::cos(angle) - 1, 0.3f * std::sin(angle), std::sin(angle));
            return pose;
          }};
}

scenes::CameraPose CameraPath::at(double seconds) const {
  return pose_at_(std::fmod(std::max(seconds, 0.0), duration_seconds_));
}

}  // namespace gnomon::client
