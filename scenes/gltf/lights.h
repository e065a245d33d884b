// Reads lights (KHR_lights_punctual). Internal to scenes/gltf/.
#pragma once

#include <optional>

#include "common/result.h"
#include "scenes/gltf/document.h"
#include "scenes/gltf/hierarchy.h"
#include "scenes/scene.h"

namespace gnomon::scenes::gltf {

// The light that a node carries; nullopt if it carries none. The light shines along the node's -Z; the node's scale
// changes neither its range nor its cone nor its extent. Error: a value of the light is not valid.
Result<std::optional<Light>> light_at(const Document& document, const PlacedNode& node);

}  // namespace gnomon::scenes::gltf
