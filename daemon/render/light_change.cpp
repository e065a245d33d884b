#include "daemon/render/light_change.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace gnomon::daemon {
namespace {

using nlohmann::json;

constexpr float kFarthest = 1e9f;  // the scene loader's limit too

std::optional<float> number(const json& value) {
  if (!value.is_number()) return std::nullopt;
  const auto out = static_cast<float>(value.get<double>());
  return std::isfinite(out) && std::abs(out) <= kFarthest ? std::optional(out) : std::nullopt;
}

std::optional<float> amount(const json& value) {
  const auto out = number(value);
  return out && *out >= 0 ? out : std::nullopt;
}

std::optional<glm::vec3> vector(const json& value) {
  if (!value.is_array() || value.size() != 3) return std::nullopt;
  glm::vec3 out;
  for (int i = 0; i < 3; ++i) {
    const auto component = number(value[static_cast<size_t>(i)]);
    if (!component) return std::nullopt;
    out[i] = *component;
  }
  return out;
}

std::optional<glm::vec3> unit(const json& value) {
  const auto out = vector(value);
  if (!out || !std::isnormal(glm::length(*out))) return std::nullopt;
  return glm::normalize(*out);
}

std::optional<glm::vec3> colour(const json& value) {
  const auto out = vector(value);
  return out && glm::all(glm::greaterThanEqual(*out, glm::vec3(0.0f))) ? out : std::nullopt;
}

json as_json(const glm::vec3& vector) { return {vector.x, vector.y, vector.z}; }

template <class T>
void replace(std::optional<T>& earlier, const std::optional<T>& later) {
  if (later) earlier = later;
}

std::optional<bool> flag(const json& value) {
  return value.is_boolean() ? std::optional(value.get<bool>()) : std::nullopt;
}

template <class T>
Result<void> read(const std::string& name, const json& value, std::optional<T> (*parse)(const json&),
                  std::optional<T>& into, const char* allowed) {
  into = parse(value);
  if (into) return {};
  return Error{name + ": allowed is " + allowed};
}

Result<void> read_member(const std::string& name, const json& value, LightChange& into) {
  if (name == "position") return read(name, value, vector, into.position, "three numbers");
  if (name == "direction") return read(name, value, unit, into.direction, "three numbers that are not all 0");
  if (name == "color") return read(name, value, colour, into.color, "three numbers of 0 or more");
  if (name == "intensity") return read(name, value, amount, into.intensity, "a number of 0 or more");
  if (name == "range") return read(name, value, amount, into.range, "a number of 0 or more; 0: unlimited");
  if (name == "on") return read(name, value, flag, into.on, "true or false");
  if (name == "as_in_file") {
    into.as_in_file = value == true;
    return into.as_in_file ? Result<void>() : Error{"as_in_file: allowed is true"};
  }
  return Error{name.substr(0, 40) +
               ": no such member; there are position, direction, color, intensity, range, on, as_in_file"};
}

}  // namespace

Result<LightChange> parse_light_change(const std::string& text) {
  const json parsed = json::parse(text, nullptr, false);
  if (!parsed.is_object()) return Error{"the body must be a JSON object"};
  LightChange change;
  for (const auto& [name, value] : parsed.items()) {
    if (auto ok = read_member(name, value, change); !ok) return ok.error();
  }
  return change;
}

std::string light_change_text(const LightChange& change) {
  json object = json::object();
  if (change.as_in_file) object["as_in_file"] = true;
  if (change.position) object["position"] = as_json(*change.position);
  if (change.direction) object["direction"] = as_json(*change.direction);
  if (change.color) object["color"] = as_json(*change.color);
  if (change.intensity) object["intensity"] = *change.intensity;
  if (change.range) object["range"] = *change.range;
  if (change.on) object["on"] = *change.on;
  return object.dump();
}

LightChange joined(const LightChange& earlier, const LightChange& later) {
  if (later.as_in_file) return later;
  LightChange both = earlier;
  replace(both.position, later.position);
  replace(both.direction, later.direction);
  replace(both.color, later.color);
  replace(both.range, later.range);
  // Both say how bright it is: what was said last holds.
  if (later.on) both.intensity.reset();
  replace(both.on, later.on);
  replace(both.intensity, later.intensity);
  return both;
}

Result<scenes::Light> changed_light(const scenes::Light& now, const scenes::Light& in_file,
                                    const LightChange& change) {
  if (now.moved_by != scenes::kNone && (change.position || change.direction)) {
    return Error{"an animation of the scene moves this light"};
  }
  scenes::Light light = change.as_in_file ? in_file : now;
  light.position = change.position.value_or(light.position);
  light.direction = change.direction.value_or(light.direction);
  light.color = change.color.value_or(light.color);
  light.range = change.range.value_or(light.range);
  if (change.on) light.intensity = *change.on ? in_file.intensity : 0.0f;
  light.intensity = change.intensity.value_or(light.intensity);
  return light;
}

}  // namespace gnomon::daemon
