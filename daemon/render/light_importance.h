// Which lights a session can best do without.
#pragma once

#include <glm/glm.hpp>
#include <span>

#include "gpu/renderer.h"
#include "scenes/scene.h"

namespace gnomon::daemon {

// All but `keep` lights: those that bring least to where the camera stands, by luminance, distance and range. Lights
// that are left out already must become half as important again to come back, so that a camera between two does not
// make them change places again and again.
gpu::LightSet least_important(std::span<const scenes::Light> lights, const glm::vec3& camera, size_t keep,
                              const gpu::LightSet& left_out);

}  // namespace gnomon::daemon
