#include "daemon/scenes/scene_lights.h"

#include "common/log.h"

namespace gnomon::daemon {

SceneLights::SceneLights(DevicePool& devices, ChangedLights known, std::filesystem::path file)
    : devices_(devices), file_(std::move(file)), changed_(std::move(known)) {
  for (const auto& [place, light] : changed_.lights()) scenes_[place.first].version = 1;
}

Result<std::optional<Error>> SceneLights::change(const std::string& scene, uint32_t light,
                                                 const LightChange& change, int64_t at_ms) {
  {
    std::lock_guard lock(mutex_);
    if (auto added = changed_.add({scene, light}, change, at_ms); !added) return added.error();
    tell(scene, light, change);
  }
  if (const auto kept = keep(); !kept) return std::optional(kept.error());
  return std::optional<Error>();
}

size_t SceneLights::take(const ChangedLights& others) {
  std::vector<ChangedLights::Place> newer;
  {
    std::lock_guard lock(mutex_);
    newer = changed_.take(others);
    for (const ChangedLights::Place& place : newer) {
      LightChange whole = changed_.lights().at(place).change;
      whole.as_in_file = true;
      tell(place.first, place.second, whole);
    }
  }
  if (!newer.empty()) (void)keep();  // it has logged its error
  return newer.size();
}

std::string SceneLights::text() const {
  std::lock_guard lock(mutex_);
  return changed_.text();
}

// A device where the scene has not arrived yet ignores the change, and asks for all of them when it has. One that has
// asked since knows this change by its version.
void SceneLights::tell(const std::string& name, uint32_t light, const LightChange& change) {
  Scene& scene = scenes_[name];
  ++scene.version;
  if (scene.id) devices_.change_light({*scene.id, light, change, scene.version});
}

// A render thread may wait for the changes, and must not wait for a disk. The last to write has the newest ones.
Result<void> SceneLights::keep() {
  if (file_.empty()) return {};
  std::lock_guard writing(file_mutex_);
  ChangedLights now;
  {
    std::lock_guard lock(mutex_);
    now = changed_;
  }
  auto written = now.write(file_);
  if (!written) log::error("changed lights are not kept for the next start", {{"why", written.error().message}});
  return written;
}

LightsUpdate SceneLights::lights_of(const std::string& scene, const std::vector<scenes::Light>& in_file) const {
  std::lock_guard lock(mutex_);
  return {scene, scenes_.at(scene).version, changed_.applied(scene, in_file)};
}

void SceneLights::bring(const SceneLoaded& arriving) {
  {
    std::lock_guard lock(mutex_);
    scenes_[arriving.name].id = arriving.scene.id;
  }
  SceneLoaded with_lights = arriving;
  with_lights.lights = [this, name = arriving.name, scene = arriving.scene.scene] {
    return lights_of(name, scene->lights);
  };
  devices_.bring(with_lights);
}

}  // namespace gnomon::daemon
