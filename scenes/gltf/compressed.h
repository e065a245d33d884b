// Geometry that a file holds compressed, by extensions that are not read. Internal to scenes/gltf/.
#pragma once

#include <nlohmann/json.hpp>

#include "common/result.h"

namespace gnomon::scenes::gltf {

// A file that only uses such an extension, without requiring it, has its geometry a second time for those who do not
// know it. Error: this file has not, and the extension is named. `root`: as it was parsed, of any shape.
Result<void> check_fallbacks(const nlohmann::json& root);

}  // namespace gnomon::scenes::gltf
