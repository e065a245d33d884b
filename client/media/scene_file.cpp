#include "client/media/scene_file.h"

#include "common/printable.h"
#include "scenes/loader.h"

namespace gnomon::client {
namespace fs = std::filesystem;
namespace {

fs::path built_in_folder() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return error ? fs::path() : program.parent_path().parent_path() / "share" / "gnomon" / "scenes";
}

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

}  // namespace

std::optional<fs::path> find_scene_file(const std::string& scene, const fs::path& scene_folder) {
  if (is_file(scene)) return scene;
  for (const fs::path& folder : {scene_folder, built_in_folder()}) {
    if (folder.empty()) continue;
    for (const char* extension : {".glb", ".gltf"}) {
      const fs::path file = folder / (scene + extension);
      if (is_file(file)) return file;
    }
  }
  return std::nullopt;
}

Result<scenes::ScenePtr> load_own_scene(const std::string& scene, const fs::path& scene_folder,
                                        const std::vector<protocol::NodeMotion>& motions) {
  const auto file = find_scene_file(scene, scene_folder);
  if (!file) {
    std::string looked = built_in_folder().string();
    if (!scene_folder.empty()) looked = scene_folder.string() + " and " + looked;
    return Error{std::string("no copy of scene '") + scene + "' here: it is no file, nor a .glb or .gltf in " +
                 looked};
  }
  std::vector<scenes::NodeMotion> given;
  for (const protocol::NodeMotion& m : motions) {
    given.push_back({m.node,
                     static_cast<scenes::NodeMotion::Kind>(m.kind),
                     {m.vector[0], m.vector[1], m.vector[2]},
                     std::chrono::microseconds(m.period_us)});
  }
  return scenes::load_scene(*file, {}, given);
}

Result<void> check_same_scene(const scenes::Scene& own, const protocol::SceneManifest& server) {
  if (own.content_hash == server.content_hash) return {};
  return Error{std::string("scene '") + without_controls(server.name) +
               "' here is not the server's: content hash " + scenes::to_hex(own.content_hash) +
               ", the server has " + scenes::to_hex(server.content_hash)};
}

}  // namespace gnomon::client
