// What an operator asks of a light.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <string>

#include "common/result.h"
#include "scenes/scene.h"

namespace gnomon::daemon {

// What is left out stays as it is.
struct LightChange {
  std::optional<glm::vec3> position, direction, color;
  std::optional<float> intensity, range;
  std::optional<bool> on;  // off: intensity 0; on: that of the scene file
};

// From an object such as {"position": [0, 2, 0], "intensity": 40, "on": true}. Error: which member is wrong, and how.
Result<LightChange> parse_light_change(const std::string& json);

// Error: an animation moves the light, and the change would.
Result<scenes::Light> changed_light(const scenes::Light& now, const scenes::Light& in_file,
                                    const LightChange& change);

}  // namespace gnomon::daemon
