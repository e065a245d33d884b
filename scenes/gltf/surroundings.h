// Ambient light and sky, which glTF has no words for: `extras.gnomon` of the file's scene (docs/scenes.md). Internal to
// scenes/gltf/.
#pragma once

#include <nlohmann/json.hpp>

#include "scenes/scene.h"

namespace gnomon::scenes::gltf {

// `root`: of the file, as parsed; nothing of it is trusted. They change no bit of a mask: a member that is not what it
// should be is left out with a warning.
Surroundings read_surroundings(const nlohmann::json& root);

}  // namespace gnomon::scenes::gltf
