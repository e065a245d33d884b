#include "scenes/gltf/light_areas.h"

#include <optional>
#include <string>

#include "common/log.h"
#include "scenes/gltf/extras.h"

namespace gnomon::scenes::gltf {
namespace {

using nlohmann::json;

constexpr double kMostMetres = 1000.0;

// The length of that name, above 0; nullopt if it is not there or is no such length.
std::optional<float> length(const json& given, const char* key) {
  const json& value = member_of(given, key);
  if (!value.is_number()) return std::nullopt;
  const double metres = value.get<double>();
  if (!(metres > 0.0) || metres > kMostMetres) return std::nullopt;
  return static_cast<float>(metres);
}

std::optional<LightArea> area_of(const json& given) {
  const json& shape = member_of(given, "shape");
  const auto radius = length(given, "radius"), width = length(given, "width"), height = length(given, "height");
  const bool is_rectangle = shape.is_null() ? width && height : shape == "rectangle";
  if (is_rectangle) {
    if (!width || !height) return std::nullopt;
    return LightArea{LightShape::rectangle, {*width / 2, 0, 0}, {0, *height / 2, 0}};
  }
  if (!radius || (!shape.is_null() && shape != "sphere" && shape != "disc")) return std::nullopt;
  return LightArea{shape == "disc" ? LightShape::disc : LightShape::sphere, {*radius, 0, 0}, {0, *radius, 0}};
}

}  // namespace

LightAreas read_light_areas(const json& root) {
  LightAreas areas;
  const json& nodes = member_of(root, "nodes");
  if (!nodes.is_array()) return areas;
  for (size_t i = 0; i < nodes.size(); ++i) {
    const json& given = member_of(member_of(member_of(nodes[i], "extras"), "gnomon"), "light");
    if (given.is_null()) continue;
    if (const auto area = area_of(given)) {
      areas[static_cast<int>(i)] = *area;
    } else {
      log::warning(
          "extras.gnomon left out in part",
          {{"member", "light"},
           {"node", i},
           {"expected", "shape sphere or disc with a radius, or rectangle with width and height, in metres"}});
    }
  }
  return areas;
}

}  // namespace gnomon::scenes::gltf
