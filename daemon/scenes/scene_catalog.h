// Which scenes clients may ask for, and under which names.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "scenes/registry.h"

namespace gnomon::daemon {

// The folders of scenes.allow_files are read once, here: what a client asks for is looked up in a table and never
// becomes a path, so that no name, however written, leads out of them.
class SceneCatalog {
 public:
  // Error: a folder cannot be read, or there are more files below it than kMaxFiles.
  static Result<SceneCatalog> read(const ScenesConfig& config);

  static constexpr size_t kMaxFiles = 4096;

  // The configured scenes, then the files.
  const std::vector<scenes::SceneSource>& sources() const { return sources_; }

  // That the configuration gives to nodes of a source.
  std::vector<scenes::NodeMotion> motions(const std::string& name) const;

  // Of a scene's name, a file's path below its folder or a file's absolute path; empty: there is no such scene.
  std::string find(const std::string& asked) const;

 private:
  std::vector<scenes::SceneSource> sources_;
  std::map<std::string, std::string, std::less<>> names_;  // what clients may say -> the source's name
};

}  // namespace gnomon::daemon
