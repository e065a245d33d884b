// The extents of lights, which glTF has no words for: `extras.gnomon.light` of a light's node (docs/soft-light.md).
// Internal to scenes/gltf/.
#pragma once

#include <map>
#include <nlohmann/json.hpp>

#include "scenes/scene.h"

namespace gnomon::scenes::gltf {

// By the node's index; in the node's own axes.
using LightAreas = std::map<int, LightArea>;

// `root`: of the file, as parsed; nothing of it is trusted. An extent that is not what it should be is left out with a
// warning: the light is then a point.
LightAreas read_light_areas(const nlohmann::json& root);

}  // namespace gnomon::scenes::gltf
