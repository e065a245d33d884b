// A client's own copy of a scene: where it is, and whether it is the server's.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/result.h"
#include "protocol/types.h"
#include "scenes/scene.h"

namespace gnomon::client {

// `scene` as a file, or as NAME.glb or NAME.gltf in `scene_folder` (may be empty) or among the built-in scenes,
// which lie in ../share/gnomon/scenes beside the running program.
std::optional<std::filesystem::path> find_scene_file(const std::string& scene,
                                                     const std::filesystem::path& scene_folder);

// Finds and loads; `motions` as the server's Welcome says. Errors are one line and say where was looked.
Result<scenes::ScenePtr> load_own_scene(const std::string& scene, const std::filesystem::path& scene_folder,
                                        const std::vector<protocol::NodeMotion>& motions = {});

// Masks fit a G-buffer only if both sides rasterise the same triangles: an error unless the content hashes agree.
Result<void> check_same_scene(const scenes::Scene& own, const protocol::SceneManifest& server);

}  // namespace gnomon::client
