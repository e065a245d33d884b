#include "scenes/registry.h"

#include "common/clock.h"
#include "common/log.h"

namespace gnomon::scenes {

std::filesystem::file_time_type changed_at(const std::filesystem::path& file) {
  std::error_code error;
  const auto changed = std::filesystem::last_write_time(file, error);
  return error ? std::filesystem::file_time_type::min() : changed;
}

Result<ScenePtr> read_here(const SceneSource& source, const LoadLimits& limits, const Watch& watch) {
  return load_with_geometry(source.file, limits, source.motions, Colours::none, watch.on_share);
}

Registry::Registry(std::vector<SceneSource> sources, LoadLimits limits, SceneReader read)
    : limits_(limits), read_(std::move(read)) {
  set_sources(std::move(sources));
}

void Registry::set_sources(std::vector<SceneSource> sources) {
  std::lock_guard lock(mutex_);
  std::map<std::string, EntryPtr> next;
  for (SceneSource& source : sources) {
    const auto before = entries_.find(source.name);
    const bool same = before != entries_.end() && before->second->source == source;
    const std::string name = source.name;
    next[name] = same ? before->second : std::make_shared<Entry>(std::move(source), SceneId{next_id_++});
  }
  entries_ = std::move(next);
}

Registry::EntryPtr Registry::find(const std::string& name) const {
  std::lock_guard lock(mutex_);
  const auto found = entries_.find(name);
  return found == entries_.end() ? nullptr : found->second;
}

Result<LoadedScene> Registry::get(const std::string& name, const Watch& watch, uint64_t max_bytes) {
  const EntryPtr shared = find(name);
  if (!shared) return Error{"there is no scene named '" + name + "'"};
  Entry& entry = *shared;
  std::lock_guard loading(entry.loading);
  const auto changed = changed_at(entry.source.file);
  {
    std::lock_guard lock(mutex_);
    if (entry.loaded) return *entry.loaded;
    const auto& refusal = entry.refusal;
    if (refusal && refusal->changed == changed && Clock::now() - refusal->at < kRefusalLasts) return refusal->why;
  }
  auto loaded = load(entry, watch, max_bytes);
  std::lock_guard lock(mutex_);
  if (loaded) {
    entry.loaded = *loaded;
  } else if (!watch.stop.stop_requested()) {
    entry.refusal = Refusal{loaded.error(), Clock::now(), changed};
  }
  return loaded;
}

Result<LoadedScene> Registry::load(const Entry& entry, const Watch& watch, uint64_t max_bytes) {
  const TimePoint start = Clock::now();
  LoadLimits limits = limits_;
  limits.max_scene_bytes = max_bytes;
  const Result<ScenePtr> scene = read_(entry.source, limits, watch);
  if (!scene) return scene.error();
  const LoadedScene loaded{entry.id, *scene, to_seconds(Clock::now() - start), (*scene)->memory_bytes()};
  log::info("scene loaded", {{"scene", entry.source.name},
                             {"triangles", loaded.scene->triangle_count},
                             {"lights", loaded.scene->lights.size()},
                             {"seconds", loaded.load_seconds},
                             {"bytes", loaded.memory_bytes}});
  return loaded;
}

void Registry::forget(const std::string& name) {
  std::lock_guard lock(mutex_);
  const auto found = entries_.find(name);
  if (found == entries_.end()) return;
  found->second->loaded.reset();
  found->second->refusal.reset();
}

void Registry::refuse(const std::string& name, Error why) {
  const EntryPtr entry = find(name);
  if (!entry) return;
  const auto changed = changed_at(entry->source.file);
  std::lock_guard lock(mutex_);
  entry->loaded.reset();
  entry->refusal = Refusal{std::move(why), Clock::now(), changed};
}

void Registry::retry(const std::string& name) {
  std::lock_guard lock(mutex_);
  if (const auto found = entries_.find(name); found != entries_.end()) found->second->refusal.reset();
}

bool Registry::knows(const std::string& name) const { return find(name) != nullptr; }

std::vector<std::string> Registry::names() const {
  std::lock_guard lock(mutex_);
  std::vector<std::string> names;
  for (const auto& [name, entry] : entries_) names.push_back(name);
  return names;
}

std::vector<LoadedScene> Registry::loaded() const {
  std::lock_guard lock(mutex_);
  std::vector<LoadedScene> loaded;
  for (const auto& [name, entry] : entries_) {
    if (entry->loaded) loaded.push_back(*entry->loaded);
  }
  return loaded;
}

}  // namespace gnomon::scenes
