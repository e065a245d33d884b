// Keeps what operators have changed of the lights of scenes, and tells the devices: also of scenes that come to them later,
// and over restarts where there is a file for it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "common/result.h"
#include "daemon/render/device_pool.h"
#include "daemon/scenes/changed_lights.h"

namespace gnomon::daemon {

// Any thread.
class SceneLights {
 public:
  // `devices` outlives this object. `file`: of what is changed from now on; if empty, it is kept as long as this object.
  SceneLights(DevicePool& devices, ChangedLights known, std::filesystem::path file);

  // Precondition: the change fits the light, if the scene is resident. Error if so many lights are changed already. The error
  // within a success: the change is in force, and could not be kept for the next start.
  Result<std::optional<Error>> change(const std::string& scene, uint32_t light, const LightChange& change,
                                      int64_t at_ms);
  // Takes over what is newer in `others`. Returns how many lights that are.
  size_t take(const ChangedLights& others);
  std::string text() const;

  // Makes a scene that is brought to the devices show its changed lights from its first frame on.
  void bring(const SceneLoaded& arriving);

 private:
  struct Scene {
    std::optional<SceneId> id;  // the one that was brought last
    uint32_t version = 0;       // of its lights: counts the changes, over all of its comings and goings
  };

  void tell(const std::string& scene, uint32_t light, const LightChange& change);  // with mutex_ held
  Result<void> keep();
  LightsUpdate lights_of(const std::string& scene, const std::vector<scenes::Light>& in_file) const;

  DevicePool& devices_;
  const std::filesystem::path file_;
  std::mutex file_mutex_;  // held while the file is written
  mutable std::mutex mutex_;
  ChangedLights changed_;                // guarded by mutex_
  std::map<std::string, Scene> scenes_;  // guarded by mutex_
};

}  // namespace gnomon::daemon
