#include "scenes/registry.h"

#include "common/clock.h"
#include "common/log.h"

namespace gnomon::scenes {

Registry::Registry(std::vector<SceneSource> sources, LoadLimits limits) : limits_(limits) {
  uint32_t index = 0;
  for (SceneSource& source : sources) {
    Entry& entry = entries_[source.name];
    entry.id = SceneId{index++};
    entry.source = std::move(source);
  }
}

Result<LoadedScene> Registry::get(const std::string& name) {
  const auto found = entries_.find(name);
  if (found == entries_.end()) return Error{"there is no scene named '" + name + "'"};
  Entry& entry = found->second;
  std::lock_guard loading(entry.loading);
  {
    std::lock_guard lock(mutex_);
    if (entry.loaded) return *entry.loaded;
  }
  const TimePoint start = Clock::now();
  Result<ScenePtr> scene = load_scene(entry.source.file, limits_, entry.source.motions);
  if (!scene) return scene.error();
  const LoadedScene loaded{entry.id, *scene, to_seconds(Clock::now() - start), (*scene)->memory_bytes()};
  log::info("scene loaded", {{"scene", name},
                             {"triangles", loaded.scene->triangle_count},
                             {"lights", loaded.scene->lights.size()},
                             {"seconds", loaded.load_seconds},
                             {"bytes", loaded.memory_bytes}});
  std::lock_guard lock(mutex_);
  entry.loaded = loaded;
  return loaded;
}

void Registry::forget(const std::string& name) {
  std::lock_guard lock(mutex_);
  if (const auto found = entries_.find(name); found != entries_.end()) found->second.loaded.reset();
}

bool Registry::knows(const std::string& name) const { return entries_.count(name) != 0; }

std::vector<std::string> Registry::names() const {
  std::vector<std::string> names;
  for (const auto& [name, entry] : entries_) names.push_back(name);
  return names;
}

std::vector<LoadedScene> Registry::loaded() const {
  std::lock_guard lock(mutex_);
  std::vector<LoadedScene> loaded;
  for (const auto& [name, entry] : entries_) {
    if (entry.loaded) loaded.push_back(*entry.loaded);
  }
  return loaded;
}

}  // namespace gnomon::scenes
