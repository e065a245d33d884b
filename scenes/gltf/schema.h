// Checks the types of JSON values that tinygltf would otherwise treat as absent, wrap around or truncate. Internal to
// scenes/gltf/.
#pragma once

#include <nlohmann/json.hpp>

#include "common/result.h"

namespace gnomon::scenes::gltf {

// Error: a value has another type; the message names the place and the type, as "nodes 3: 'translation' is not an array
// of numbers". A missing value is not an error.
Result<void> check_types(const nlohmann::json& root);

}  // namespace gnomon::scenes::gltf
