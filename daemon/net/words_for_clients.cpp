#include "daemon/net/words_for_clients.h"

#include <algorithm>

namespace gnomon::daemon {
namespace {

constexpr size_t kMostScenesNamed = 16;

uint8_t percent_of(const std::optional<double>& share) {
  return share ? static_cast<uint8_t>(100 * std::clamp(*share, 0.0, 1.0)) : protocol::Waiting::kUnknown;
}

}  // namespace

protocol::Refused with_scenes(protocol::Refused refused, const SceneCatalog& catalog) {
  if (refused.code != protocol::RefusalCode::unknown_scene) return refused;
  const auto& sources = catalog.sources();
  const size_t named = std::min(sources.size(), kMostScenesNamed);
  for (size_t i = 0; i < named; ++i) refused.text += (i == 0 ? "; there are: " : ", ") + sources[i].name;
  if (named < sources.size()) refused.text += " and " + std::to_string(sources.size() - named) + " more";
  return refused;
}

protocol::Waiting what_is_waited_for(const Health& health, const std::optional<SceneUnderWay>& scene) {
  if (!health.serving) return {"the server is starting"};
  if (!scene) return {"a place on the devices"};
  switch (scene->stage) {
    case SceneUnderWay::Stage::queued: return {"the scene is to be read, after others"};
    case SceneUnderWay::Stage::reading: return {"the scene is being read", percent_of(scene->share)};
    case SceneUnderWay::Stage::preparing: return {"the scene is being prepared on the devices"};
  }
  return {""};
}

std::string without_folder(std::string why, const std::string& scene, const SceneCatalog& catalog) {
  const auto& sources = catalog.sources();
  const auto source = std::find_if(sources.begin(), sources.end(), [&](const auto& s) { return s.name == scene; });
  if (source == sources.end()) return why;
  const std::string folder = source->file.parent_path().string() + "/";
  for (size_t at = 0; (at = why.find(folder, at)) != std::string::npos;) why.erase(at, folder.size());
  return why;
}

}  // namespace gnomon::daemon
