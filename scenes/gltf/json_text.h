// Reads the JSON of a glTF file and makes it safe for tinygltf. Internal to scenes/gltf/.
#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

#include "common/result.h"
#include "scenes/gltf/light_areas.h"
#include "scenes/scene.h"

namespace gnomon::scenes::gltf {

// What Gnomon reads of a file's extras.
struct Extras {
  Surroundings surroundings;
  LightAreas light_areas;
};

// Error: the text is not a glTF 2 object, requires an extension that is not supported or stands only in one, is nested
// too deeply for recursive code, or has too many entries. The result leaves out all extensions that the loader does not
// read, and all extras, of which `extras` gets what Gnomon reads.
Result<nlohmann::json> parse_gltf_json(std::string_view text, Extras& extras);

}  // namespace gnomon::scenes::gltf
