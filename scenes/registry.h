// Scenes by name. Each is loaded once, however many clients use it.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/clock.h"
#include "common/ids.h"
#include "common/result.h"
#include "scenes/loader.h"
#include "scenes/scene.h"

namespace gnomon::scenes {

struct SceneSource {
  std::string name;  // what clients ask for
  std::filesystem::path file;
  std::vector<NodeMotion> motions = {};
  std::filesystem::file_time_type changed =
      {};  // the file, when the sources were listed: then it is another source
  friend bool operator==(const SceneSource&, const SceneSource&) = default;
};

// When the file was changed last; the earliest time there is for one that cannot be looked at. Any thread.
std::filesystem::file_time_type changed_at(const std::filesystem::path& file);

struct LoadedScene {
  SceneId id;
  ScenePtr scene;
  double load_seconds = 0;
  uint64_t memory_bytes = 0;  // of host memory
};

// Who may end the reading of a scene, and who is told how far it is.
struct Watch {
  std::stop_token stop = {};
  OnShare on_share = {};
};

// How a scene is read: load_scene() in this process, or what reads it in another one. Blocks; called by any thread.
// After a request to stop, the result is an error, or the scene if it was already there.
using SceneReader =
    std::function<Result<ScenePtr>(const SceneSource& source, const LoadLimits& limits, const Watch& watch)>;
// Reads in this process, and does not stop.
Result<ScenePtr> read_here(const SceneSource& source, const LoadLimits& limits, const Watch& watch = {});

// Any thread. The first caller of get() loads the scene and blocks; concurrent callers wait for it and share the scene.
class Registry {
 public:
  // How long a scene that could not be loaded is refused for the same reason without reading it again, if its file has
  // not changed. A file that is slow to refuse costs its time once.
  static constexpr Nanoseconds kRefusalLasts = std::chrono::minutes(1);

  Registry(std::vector<SceneSource> sources, LoadLimits limits, SceneReader read = read_here);

  // Replaces the sources. Those that are as before keep their scenes; the others are forgotten.
  void set_sources(std::vector<SceneSource> sources);

  // Error: there is no such scene, it could not be loaded, or reading it was stopped, which is no refusal.
  // `max_bytes`: LoadLimits::max_scene_bytes of this reading.
  Result<LoadedScene> get(const std::string& name, const Watch& watch = {}, uint64_t max_bytes = 0);

  // Makes the next get() read the file again, also if it was refused. Scenes that were returned before stay valid.
  void forget(const std::string& name);

  // Lets go of the scene, and refuses it for that reason as one that could not be loaded.
  void refuse(const std::string& name, Error why);

  // Makes the next get() read the file again if it was refused.
  void retry(const std::string& name);

  bool knows(const std::string& name) const;
  std::vector<std::string> names() const;
  std::vector<LoadedScene> loaded() const;

 private:
  struct Refusal {
    Error why;
    TimePoint at;
    std::filesystem::file_time_type changed;  // the file's, when it was read
  };
  struct Entry {
    Entry(SceneSource made_of, SceneId number) : source(std::move(made_of)), id(number) {}
    const SceneSource source;
    const SceneId id;
    std::mutex loading;
    std::optional<LoadedScene> loaded;
    std::optional<Refusal> refusal;
  };

  using EntryPtr = std::shared_ptr<Entry>;  // shared with those who load it
  EntryPtr find(const std::string& name) const;
  Result<LoadedScene> load(const Entry& entry, const Watch& watch, uint64_t max_bytes);

  const LoadLimits limits_;
  const SceneReader read_;
  mutable std::mutex mutex_;  // guards what follows, and every Entry::loaded and Entry::refusal
  std::map<std::string, EntryPtr> entries_;
  uint32_t next_id_ = 0;
};

}  // namespace gnomon::scenes
