// Views of any scene: for scenes without a camera, and for paths where the scene's camera does not move.
#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "scenes/scene.h"

namespace gnomon::scenes {
namespace {

constexpr float kFieldOfView = 0.9f;

bool inside(const Bounds& bounds, const glm::vec3& p) {
  return glm::all(glm::greaterThan(p, bounds.min)) && glm::all(glm::lessThan(p, bounds.max));
}

// A scene with a lamp inside its bounds is taken for an interior.
bool is_interior(const Scene& scene) {
  return std::any_of(scene.lights.begin(), scene.lights.end(), [&](const Light& light) {
    return light.type != LightType::directional && inside(scene.bounds, light.position);
  });
}

}  // namespace

CameraPose orbit_pose(const Scene& scene, float seconds) {
  const float turns = std::isfinite(seconds) ? seconds / kOrbitSeconds : 0.0f;
  const float angle = glm::two_pi<float>() * (turns - std::floor(turns));
  const glm::vec3 centre = 0.5f * scene.bounds.min + 0.5f * scene.bounds.max;
  const glm::vec3 half = 0.5f * scene.bounds.max - 0.5f * scene.bounds.min;
  const glm::vec3 around(std::cos(angle), 0.0f, std::sin(angle));

  CameraPose pose;
  pose.vertical_fov = kFieldOfView;
  glm::vec3 offset = 0.5f * half * around;
  if (!is_interior(scene)) {
    const float radius = std::max(glm::length(half), 1e-3f);
    offset = glm::normalize(around + glm::vec3(0.0f, 0.4f, 0.0f)) * (radius / std::sin(0.5f * kFieldOfView));
  }
  pose.position = centre + offset;
  const float distance = glm::length(offset);
  const bool somewhere = std::isnormal(distance) && std::abs(offset.y) < 0.99f * distance;
  pose.orientation = glm::quatLookAt(somewhere ? -offset / distance : -around, glm::vec3(0.0f, 1.0f, 0.0f));
  return pose;
}

}  // namespace gnomon::scenes
