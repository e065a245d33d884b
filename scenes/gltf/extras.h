// Looks into a file's extras, of which nothing is trusted. Internal to scenes/gltf/.
#pragma once

#include <nlohmann/json.hpp>

namespace gnomon::scenes::gltf {

// The member of that name; a null value if `object` has none or is no object.
inline const nlohmann::json& member_of(const nlohmann::json& object, const char* key) {
  static const nlohmann::json none;
  if (!object.is_object()) return none;
  const auto found = object.find(key);
  return found == object.end() ? none : *found;
}

}  // namespace gnomon::scenes::gltf
