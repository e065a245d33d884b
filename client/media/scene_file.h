// Finds a client's own copy of a scene and checks that it is the server's.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/result.h"
#include "protocol/types.h"
#include "scenes/scene.h"

namespace gnomon::client {

// Finds `scene`, which is a file, or the name of a .glb or .gltf in `scene_folder` (may be empty) or among the built-in
// scenes, which are in ../share/gnomon/scenes relative to the running program. nullopt if there is no such file.
std::optional<std::filesystem::path> find_scene_file(const std::string& scene,
                                                     const std::filesystem::path& scene_folder);

// Finds and loads the scene, with the `motions` of the server's Welcome. Error: one line, which names the places
// searched.
Result<scenes::ScenePtr> load_own_scene(const std::string& scene, const std::filesystem::path& scene_folder,
                                        const std::vector<protocol::NodeMotion>& motions = {});

// Error unless the content hashes are equal: masks fit a G-buffer only if both sides rasterise the same triangles.
Result<void> check_same_scene(const scenes::Scene& own, const protocol::SceneManifest& server);

}  // namespace gnomon::client
