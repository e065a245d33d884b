#include "scenes/gltf/lights.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <string>

#include "scenes/pose.h"

namespace gnomon::scenes::gltf {
namespace {

Result<LightType> type_of(const std::string& name) {
  if (name == "point") return LightType::point;
  if (name == "spot") return LightType::spot;
  if (name == "directional") return LightType::directional;
  return Error{"has the unknown type '" + name + "'"};
}

bool is_finite_and_not_negative(double v) { return v >= 0.0 && std::isfinite(static_cast<float>(v)); }

Result<void> set_cone(const tinygltf::SpotLight& spot, Light& light) {
  const double outer = spot.outerConeAngle;
  const double inner = spot.innerConeAngle;
  if (!(outer > 0.0) || outer > glm::half_pi<double>() + 1e-4) {
    return Error{"has an outer cone angle that is not between 0 and pi/2"};
  }
  if (!(inner >= 0.0)) return Error{"has a negative inner cone angle"};
  light.outer_cone_cos = static_cast<float>(std::max(std::cos(outer), 0.0));
  light.inner_cone_cos = std::max(static_cast<float>(std::cos(std::min(inner, outer))), light.outer_cone_cos);
  return {};
}

Result<void> set_strength(const tinygltf::Light& source, Light& light) {
  if (!is_finite_and_not_negative(source.intensity)) return Error{"has an intensity below 0"};
  if (!is_finite_and_not_negative(source.range)) return Error{"has a range below 0"};
  light.intensity = static_cast<float>(source.intensity);
  light.range = static_cast<float>(source.range);
  if (source.color.empty()) return {};
  if (source.color.size() != 3) return Error{"has a colour that is not 3 numbers"};
  for (int i = 0; i < 3; ++i) {
    const double channel = source.color[static_cast<size_t>(i)];
    if (!is_finite_and_not_negative(channel)) return Error{"has a colour below 0"};
    light.color[i] = static_cast<float>(channel);
  }
  return {};
}

// Metres. Squares of distances must stay within the range of floats.
constexpr float kFarthest = 1e9f;

Result<void> set_place(const PlacedNode& node, Light& light) {
  Light placed = light;
  const bool directed = place_light(node.to_world, placed);
  light.position = placed.position;
  light.area = placed.area;
  const glm::vec3 away = glm::abs(light.position);
  if (std::max({away.x, away.y, away.z}) > kFarthest) return Error{"stands farther away than a million kilometres"};
  if (light.type == LightType::point) return {};
  if (!directed) return Error{"has no direction: its node is scaled to nothing"};
  light.direction = placed.direction;
  return {};
}

Result<Light> convert(const tinygltf::Light& source, const PlacedNode& node, const LightAreas& areas) {
  const auto type = type_of(source.type);
  if (!type) return type.error();
  Light light;
  light.type = *type;
  const auto area = areas.find(node.node);
  if (area != areas.end() && light.type != LightType::directional) light.area = area->second;
  if (const auto ok = set_strength(source, light); !ok) return ok.error();
  if (const auto ok = set_place(node, light); !ok) return ok.error();
  if (light.type == LightType::spot) {
    if (const auto ok = set_cone(source.spot, light); !ok) return ok.error();
  }
  return light;
}

}  // namespace

Result<std::optional<Light>> light_at(const Document& document, const PlacedNode& node) {
  const tinygltf::Model& model = document.model;
  const tinygltf::Node& source = model.nodes[static_cast<size_t>(node.node)];
  const auto extension = source.extensions.find("KHR_lights_punctual");
  if (extension == source.extensions.end() || !extension->second.Has("light")) return std::optional<Light>();
  const tinygltf::Value& index = extension->second.Get("light");
  if (!index.IsInt()) return Error{node_name(model, node.node) + " names a light by something other than a number"};
  const auto found = entry(model.lights, index.GetNumberAsInt(), "light");
  if (!found) return Error{node_name(model, node.node) + ": " + found.error().message};
  Result<Light> light = convert(**found, node, document.extras.light_areas);
  const std::string name = (*found)->name.empty() ? source.name : (*found)->name;
  if (!light)
    return Error{"light " + std::to_string(index.GetNumberAsInt()) + " '" + name + "' " + light.error().message};
  light->name = name;
  return std::optional<Light>(std::move(*light));
}

}  // namespace gnomon::scenes::gltf
