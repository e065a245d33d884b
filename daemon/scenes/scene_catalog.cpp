#include "daemon/scenes/scene_catalog.h"

#include <algorithm>

namespace gnomon::daemon {
namespace fs = std::filesystem;

std::vector<scenes::NodeMotion> motions_of(const SceneFile& scene) {
  std::vector<scenes::NodeMotion> motions;
  for (const MovingNode& moving : scene.moving) {
    const bool spins = !moving.spin.empty();
    const std::vector<float>& v = spins ? moving.spin : moving.shift;
    motions.push_back({moving.node,
                       spins ? scenes::NodeMotion::Kind::spin : scenes::NodeMotion::Kind::shift,
                       {v[0], v[1], v[2]},
                       moving.period});
  }
  return motions;
}

namespace {

bool is_gltf(const fs::directory_entry& entry) {
  const auto extension = entry.path().extension();
  std::error_code error;
  return (extension == ".gltf" || extension == ".glb") && entry.is_regular_file(error);
}

}  // namespace

Result<SceneCatalog> SceneCatalog::read(const ScenesConfig& config) {
  SceneCatalog catalog;
  for (const SceneFile& scene : config.list) {
    catalog.sources_.push_back({scene.name, scene.file, motions_of(scene), scenes::changed_at(scene.file)});
    catalog.names_[scene.name] = scene.name;
  }
  for (const fs::path& folder : config.allow_files) {
    std::error_code error;
    fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, error);
    for (; !error && at != fs::recursive_directory_iterator(); at.increment(error)) {
      if (!is_gltf(*at)) continue;
      if (catalog.sources_.size() == kMaxFiles) {
        catalog.left_out_ = "scenes.allow_files: " + folder.string() + " brings the scenes to more than " +
                            std::to_string(kMaxFiles) + ", and the others are left out";
        break;
      }
      const std::string name = at->path().lexically_relative(folder).generic_string();
      if (!catalog.names_.emplace(name, name).second) continue;  // the first folder wins
      catalog.names_[at->path().string()] = name;
      catalog.sources_.push_back({name, at->path(), {}, scenes::changed_at(at->path())});
    }
    if (error) return Error{"scenes.allow_files: " + folder.string() + ": " + error.message()};
  }
  return catalog;
}

const scenes::SceneSource* SceneCatalog::source(const std::string& name) const {
  const auto found = std::find_if(sources_.begin(), sources_.end(), [&](const auto& s) { return s.name == name; });
  return found == sources_.end() ? nullptr : &*found;
}

void SceneCatalog::keep(const std::string& name, const SceneCatalog& before) {
  const scenes::SceneSource* const kept = before.source(name);
  if (!kept) return;
  std::erase_if(sources_, [&](const auto& source) { return source.name == name; });
  sources_.push_back(*kept);
  names_[name] = name;
}

std::vector<scenes::NodeMotion> SceneCatalog::motions(const std::string& name) const {
  const scenes::SceneSource* const found = source(name);
  return found ? found->motions : std::vector<scenes::NodeMotion>{};
}

std::string SceneCatalog::find(const std::string& asked) const {
  const auto found = names_.find(asked);
  return found == names_.end() ? "" : found->second;
}

}  // namespace gnomon::daemon
