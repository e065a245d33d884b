// Scenes by name or file, and the cameras that benchmarks look through.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/result.h"
#include "gpu/renderer.h"
#include "scenes/scene.h"

namespace gnomon::bench {

// The built-in scenes and those beside the repository that are there.
std::vector<std::string> default_scenes();

// `scene`: a built-in's name, one beside the repository, or a file.
Result<scenes::ScenePtr> open_scene(const std::string& scene);
Result<std::filesystem::path> scene_file(const std::string& scene);

struct PictureSize {
  uint32_t width = 0, height = 0;
};
// "1920x1080".
Result<PictureSize> parse_size(const std::string& text);

// How long the scene's first camera path takes; without one, a turn of the circle through it (orbit_pose).
double path_seconds(const scenes::Scene& scene);
// Where a client is on that path, before its beginning at the beginning.
gpu::CameraView camera_on_path(const scenes::Scene& scene, double seconds, PictureSize size);

// `count` cameras evenly along it.
std::vector<gpu::CameraView> cameras_along_path(const scenes::Scene& scene, uint32_t count, PictureSize size);

}  // namespace gnomon::bench
