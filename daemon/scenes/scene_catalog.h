// The scenes that clients may ask for, and their names.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "scenes/registry.h"

namespace gnomon::daemon {

// Why a scene is not served in which nothing shines.
inline constexpr const char* kNoLights = "it has no lights: there is nothing to trace";

// The motions that the configuration gives to nodes of the scene's file.
std::vector<scenes::NodeMotion> motions_of(const SceneFile& scene);

// The folders of scenes.allow_files are read once, at the start and at each reload: what a client asks for is looked up in
// a table and is never used as a path, so that no name, however written, leads out of the folders. Immutable afterwards;
// any thread.
class SceneCatalog {
 public:
  // Error if a folder cannot be read. Scenes beyond kMaxFiles are left out, since who may put files into a folder must
  // not keep the daemon from starting; left_out() says so.
  static Result<SceneCatalog> read(const ScenesConfig& config);

  // Scenes of this name are what they were in `before`.
  void keep(const std::string& name, const SceneCatalog& before);

  static constexpr size_t kMaxFiles = 4096;

  const std::string& left_out() const { return left_out_; }  // with its key; empty: all are there

  // The configured scenes, then the files.
  const std::vector<scenes::SceneSource>& sources() const { return sources_; }
  const scenes::SceneSource* source(const std::string& name) const;  // nullptr if there is none

  // The motions that the configuration gives to nodes of the source.
  std::vector<scenes::NodeMotion> motions(const std::string& name) const;

  // Returns the source's name for a scene's name, a file's path below its folder or a file's absolute path; an empty
  // string if there is no such scene.
  std::string find(const std::string& asked) const;

 private:
  std::string left_out_;
  std::vector<scenes::SceneSource> sources_;
  std::map<std::string, std::string, std::less<>> names_;  // what clients may ask for -> the source's name
};

}  // namespace gnomon::daemon
