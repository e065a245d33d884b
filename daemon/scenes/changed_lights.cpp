#include "daemon/scenes/changed_lights.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "daemon/security/readable_file.h"

namespace gnomon::daemon {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

// The latest time that a change may have, which every JSON reader has exactly.
constexpr uint64_t kLatestMs = uint64_t{1} << 53;

const Error kTooMany{"more than " + std::to_string(ChangedLights::kMost) + " lights are changed"};

Result<std::pair<ChangedLights::Place, ChangedLights::Light>> light_of(const json& object) {
  const auto member = [&](const char* name) { return object.is_object() ? object.value(name, json()) : json(); };
  const json scene = member("scene"), number = member("light"), at = member("at_ms"), change = member("change");
  const bool numbered = number.is_number_unsigned() && number.get<uint64_t>() <= ChangedLights::kMostNumber;
  const bool dated = at.is_number_unsigned() && at.get<uint64_t>() <= kLatestMs;
  if (!scene.is_string() || !numbered || !dated || !change.is_object())
    return Error{"every one of lights has a scene's name, a light's number, at_ms and change"};
  const auto parsed = parse_light_change(change.dump(-1, ' ', false, json::error_handler_t::replace));
  if (!parsed) return parsed.error();
  const ChangedLights::Place place{scene.get<std::string>(), number.get<uint32_t>()};
  return std::pair{place, ChangedLights::Light{at.get<int64_t>(), *parsed}};
}

}  // namespace

Result<ChangedLights> ChangedLights::parse(const std::string& text) {
  const json parsed = json::parse(text, nullptr, false);
  if (!parsed.is_object() || !parsed.value("lights", json()).is_array())
    return Error{"there is no JSON object with a list of lights"};
  ChangedLights all;
  for (const json& each : parsed["lights"]) {
    const auto light = light_of(each);
    if (!light) return light.error();
    all.lights_.insert_or_assign(light->first, light->second);
  }
  if (all.lights_.size() > kMost) return kTooMany;
  return all;
}

Result<ChangedLights> ChangedLights::read(const fs::path& file) {
  std::error_code none;
  if (!fs::exists(file, none)) return ChangedLights();
  const auto text = read_file(file);
  if (!text) return text.error();
  const auto parsed = parse(*text);
  return parsed ? parsed : Error{file.string() + ": " + parsed.error().message};
}

std::string ChangedLights::text() const {
  json list = json::array();
  for (const auto& [place, light] : lights_) {
    list.push_back({{"scene", place.first},
                    {"light", place.second},
                    {"at_ms", light.at_ms},
                    {"change", json::parse(light_change_text(light.change))}});
  }
  // A scene file's name may not be valid UTF-8: replacement characters avoid an exception.
  return json{{"lights", list}}.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

Result<void> ChangedLights::write(const fs::path& file) const {
  const fs::path unfinished = file.string() + ".new";
  std::ofstream(unfinished, std::ios::trunc) << text();
  // On the disk before it has the name: else it may be empty after a loss of power, and an empty one stops a start.
  const int written = open(unfinished.c_str(), O_RDWR | O_CLOEXEC);
  const bool whole = written >= 0 && fs::file_size(unfinished) == text().size() && fsync(written) == 0;
  const int why = errno;
  if (written >= 0) close(written);
  std::error_code failed(written < 0 ? why : 0, std::generic_category());
  if (whole) fs::rename(unfinished, file, failed);
  if (whole && !failed) return {};
  return Error{file.string() + ": cannot be written: " + (failed ? failed.message() : "the disk takes no more")};
}

Result<void> ChangedLights::add(const Place& place, const LightChange& change, int64_t at_ms) {
  if (lights_.size() >= kMost && !lights_.contains(place)) return kTooMany;
  Light& known = lights_[place];
  known.change = joined(known.change, change);
  known.change.as_in_file = false;  // that is where a change begins
  known.at_ms = std::min(std::max(at_ms, known.at_ms + 1), static_cast<int64_t>(kLatestMs));
  return {};
}

std::vector<ChangedLights::Place> ChangedLights::take(const ChangedLights& other) {
  std::vector<Place> newer;
  for (const auto& [place, light] : other.lights_) {
    const auto known = lights_.find(place);
    const bool is_new = known == lights_.end();
    if (is_new ? lights_.size() >= kMost : known->second.at_ms >= light.at_ms) continue;
    lights_.insert_or_assign(place, light);
    newer.push_back(place);
  }
  return newer;
}

std::vector<scenes::Light> ChangedLights::applied(const std::string& scene,
                                                  std::vector<scenes::Light> lights) const {
  for (auto each = lights_.lower_bound({scene, 0}); each != lights_.end() && each->first.first == scene; ++each) {
    const uint32_t number = each->first.second;
    if (number >= lights.size()) continue;
    const auto changed = changed_light(lights[number], lights[number], each->second.change);
    if (changed) lights[number] = *changed;
  }
  return lights;
}

}  // namespace gnomon::daemon
