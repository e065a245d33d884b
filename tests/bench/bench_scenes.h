// Scenes by name or file, and the cameras of benchmarks.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/result.h"
#include "gpu/renderer.h"
#include "scenes/scene.h"

namespace gnomon::bench {

// The built-in scenes, and those beside the repository that exist.
std::vector<std::string> default_scenes();

// Those, and the scenes that are made for benches (made_scenes.h).
std::vector<std::string> all_scenes();

// `scene`: a built-in's name, one beside the repository, one that is made for benches, or a file.
Result<scenes::ScenePtr> open_scene(const std::string& scene);
Result<std::filesystem::path> scene_file(const std::string& scene);

struct PictureSize {
  uint32_t width = 0, height = 0;
};
// "1920x1080".
Result<PictureSize> parse_size(const std::string& text);

// The duration of the scene's first camera path; without a path, of a turn of the circle in the scene (orbit_pose).
double path_seconds(const scenes::Scene& scene);
// The pose on that path at a time; before its beginning, the first pose.
gpu::CameraView camera_on_path(const scenes::Scene& scene, double seconds, PictureSize size);

// `count` cameras, evenly spaced along the path.
std::vector<gpu::CameraView> cameras_along_path(const scenes::Scene& scene, uint32_t count, PictureSize size);

}  // namespace gnomon::bench
