// A change of a light by an operator.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <string>

#include "common/result.h"
#include "scenes/scene.h"

namespace gnomon::daemon {

// Members that are nullopt stay as they are.
struct LightChange {
  std::optional<glm::vec3> position, direction, color;
  std::optional<float> intensity, range;
  std::optional<bool> on;   // false: intensity 0; true: the intensity of the scene file
  bool as_in_file = false;  // before the other members: everything as the scene file has it
};

// Parses an object such as {"position": [0, 2, 0], "intensity": 40, "on": true}. The error names the wrong member and
// what is allowed.
Result<LightChange> parse_light_change(const std::string& json);

// The object that parse_light_change() makes the same change of.
std::string light_change_text(const LightChange& change);

// The change that does what `earlier` and then `later` do to a light that is as in its file.
LightChange joined(const LightChange& earlier, const LightChange& later);

// Applies the change to `now`. Error if an animation moves the light and the change would move it too.
Result<scenes::Light> changed_light(const scenes::Light& now, const scenes::Light& in_file,
                                    const LightChange& change);

}  // namespace gnomon::daemon
