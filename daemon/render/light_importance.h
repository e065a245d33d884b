// Selects the lights that a session can best do without.
#pragma once

#include <glm/glm.hpp>
#include <span>

#include "gpu/renderer.h"
#include "scenes/scene.h"

namespace gnomon::daemon {

// Returns all but `keep` lights: those that contribute least at the camera, by luminance, distance and range. A light
// in `left_out` must be 1.5 times as important as another to replace it, so that a camera between two lights does not
// make them alternate.
gpu::LightSet least_important(std::span<const scenes::Light> lights, const glm::vec3& camera, size_t keep,
                              const gpu::LightSet& left_out);

}  // namespace gnomon::daemon
