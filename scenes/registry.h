// Scenes by name. Each is loaded once, however many clients use it.
#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "common/ids.h"
#include "common/result.h"
#include "scenes/loader.h"
#include "scenes/scene.h"

namespace gnomon::scenes {

struct SceneSource {
  std::string name;  // what clients ask for
  std::filesystem::path file;
  std::vector<NodeMotion> motions = {};
};

struct LoadedScene {
  SceneId id;
  ScenePtr scene;
  double load_seconds = 0;
  uint64_t memory_bytes = 0;  // of host memory
};

// Any thread. The first caller of get() loads the scene and blocks; concurrent callers wait for it and share the scene.
class Registry {
 public:
  Registry(std::vector<SceneSource> sources, LoadLimits limits);

  // Error: there is no such scene, or it could not be loaded; a later call tries again.
  Result<LoadedScene> get(const std::string& name);

  // Makes the next get() read the file again. Scenes that were returned before stay valid.
  void forget(const std::string& name);

  bool knows(const std::string& name) const;
  std::vector<std::string> names() const;
  std::vector<LoadedScene> loaded() const;

 private:
  struct Entry {
    SceneSource source;
    SceneId id;
    std::mutex loading;
    std::optional<LoadedScene> loaded;
  };

  LoadLimits limits_;
  mutable std::mutex mutex_;  // guards every Entry::loaded
  std::map<std::string, Entry> entries_;
};

}  // namespace gnomon::scenes
