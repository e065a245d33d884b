#include "tests/bench/bench_scenes.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "scenes/loader.h"
#include "tests/bench/made_scenes.h"

namespace gnomon::bench {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> candidates(const std::string& scene) {
  return {fs::path(GNOMON_SCENES_DIR) / (scene + ".glb"),
          fs::path(GNOMON_SOURCE_DIR) / "../shared/scenes" / (scene + ".glb"), fs::path(scene)};
}

}  // namespace

std::vector<std::string> default_scenes() {
  std::vector<std::string> found;
  for (const char* name :
       {"living_room", "temple", "sponza_crytek", "oa_minia", "grey_white_room", "country_kitchen"})
    for (const fs::path& file : candidates(name))
      if (fs::is_regular_file(file)) {
        found.emplace_back(name);
        break;
      }
  return found;
}

std::vector<std::string> all_scenes() {
  std::vector<std::string> names = default_scenes();
  for (const std::string_view made : made_scene_names()) names.emplace_back(made);
  return names;
}

Result<fs::path> scene_file(const std::string& scene) {
  for (const fs::path& file : candidates(scene))
    if (fs::is_regular_file(file)) return fs::absolute(file);
  return Error{"no scene '" + scene + "': neither a name nor a file"};
}

Result<scenes::ScenePtr> open_scene(const std::string& scene) {
  if (auto made = made_scene(scene)) return made;
  const auto file = scene_file(scene);
  if (!file) return file.error();
  return scenes::load_scene(*file);
}

Result<PictureSize> parse_size(const std::string& text) {
  PictureSize size;
  const char* end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size.width);
  if (width.ec == std::errc{} && width.ptr != end && *width.ptr == 'x') {
    const auto height = std::from_chars(width.ptr + 1, end, size.height);
    if (height.ec == std::errc{} && height.ptr == end && size.width > 0 && size.height > 0) return size;
  }
  return Error{"a size is written as 1920x1080, not '" + text + "'"};
}

double path_seconds(const scenes::Scene& scene) {
  return scene.paths.empty() ? double{scenes::kOrbitSeconds} : double{scene.paths[0].duration_seconds};
}

gpu::CameraView camera_on_path(const scenes::Scene& scene, double seconds, PictureSize size) {
  const auto when = static_cast<float>(std::max(0.0, seconds));
  const scenes::CameraPose pose =
      scene.paths.empty()
          ? scenes::orbit_pose(scene, when)
          : scenes::pose_at(scene.paths[0], scene.cameras[scene.paths[0].camera].rest.vertical_fov, when);
  gpu::CameraView view;
  view.position = pose.position;
  view.orientation = pose.orientation;
  view.tan_up = view.tan_down = std::tan(pose.vertical_fov / 2);
  view.tan_left = view.tan_right = view.tan_up * static_cast<float>(size.width) / static_cast<float>(size.height);
  return view;
}

std::vector<gpu::CameraView> cameras_along_path(const scenes::Scene& scene, uint32_t count, PictureSize size) {
  std::vector<gpu::CameraView> views;
  for (uint32_t i = 0; i < count; ++i)
    views.push_back(camera_on_path(scene, path_seconds(scene) * (i + 0.5) / count, size));
  return views;
}

}  // namespace gnomon::bench
