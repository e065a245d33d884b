// Types of the JSON values that tinygltf would otherwise take for absent, wrap around or cut. Internal to
// scenes/gltf/.
#pragma once

#include <nlohmann/json.hpp>

#include "common/result.h"

namespace gnomon::scenes::gltf {

// Error: names the place and what it should hold, as "nodes 3: 'translation' is not an array of numbers". A missing
// value is no error.
Result<void> check_types(const nlohmann::json& root);

}  // namespace gnomon::scenes::gltf
