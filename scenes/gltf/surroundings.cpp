#include "scenes/gltf/surroundings.h"

#include <string>

#include "common/log.h"
#include "scenes/gltf/extras.h"

namespace gnomon::scenes::gltf {
namespace {

using nlohmann::json;

constexpr double kMost = 1e6;          // radiance; beyond it nothing would be left of a picture
constexpr double kMostReach = 1000.0;  // metres

void leave_out(const char* group, const char* key, const char* expected) {
  log::warning("extras.gnomon left out in part",
               {{"member", std::string(group) + "." + key}, {"expected", expected}});
}

bool is_radiance(const json& v) { return v.is_number() && v.get<double>() >= 0.0 && v.get<double>() <= kMost; }

void read_colour(const json& object, const char* group, const char* key, glm::vec3& into) {
  const json& value = member_of(object, key);
  if (value.is_null()) return;
  if (!value.is_array() || value.size() != 3 || !is_radiance(value[0]) || !is_radiance(value[1]) ||
      !is_radiance(value[2])) {
    return leave_out(group, key, "three numbers from 0 to 1000000");
  }
  into = {value[0].get<float>(), value[1].get<float>(), value[2].get<float>()};
}

void read_number(const json& object, const char* group, const char* key, double most, float& into) {
  const json& value = member_of(object, key);
  if (value.is_null()) return;
  if (value.is_number() && value.get<double>() >= 0.0 && value.get<double>() <= most) {
    into = value.get<float>();
  } else {
    leave_out(group, key, ("a number from 0 to " + std::to_string(static_cast<int>(most))).c_str());
  }
}

}  // namespace

Surroundings read_surroundings(const json& root) {
  Surroundings out;
  const json& scenes = member_of(root, "scenes");
  const json& index = member_of(root, "scene");
  const size_t shown = index.is_number_unsigned() ? index.get<size_t>() : 0;
  if (!scenes.is_array() || shown >= scenes.size()) return out;
  const json& given = member_of(member_of(scenes[shown], "extras"), "gnomon");
  const json& ambient = member_of(given, "ambient");
  read_colour(ambient, "ambient", "above", out.ambient_above);
  read_colour(ambient, "ambient", "below", out.ambient_below);
  read_number(ambient, "ambient", "reach", kMostReach, out.ambient_reach);
  const json& sky = member_of(given, "sky");
  out.has_sky = sky.is_object();
  read_colour(sky, "sky", "zenith", out.sky_zenith);
  read_colour(sky, "sky", "horizon", out.sky_horizon);
  read_colour(sky, "sky", "ground", out.sky_ground);
  read_number(sky, "sky", "clouds", 1.0, out.sky_clouds);
  return out;
}

}  // namespace gnomon::scenes::gltf
