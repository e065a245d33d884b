// The JSON of a glTF file, made safe for tinygltf. Internal to scenes/gltf/.
#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

#include "common/result.h"

namespace gnomon::scenes::gltf {

// Refuses what is no glTF 2 object, requires an extension that we do not support, is nested too deeply for code that
// recurses, or has more entries than memory should pay for. Leaves out what nobody reads: extras, and extensions
// other than those supported.
Result<nlohmann::json> parse_gltf_json(std::string_view text);

}  // namespace gnomon::scenes::gltf
