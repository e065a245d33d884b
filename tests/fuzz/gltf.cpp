// A scene file, text or binary: a scene, or an error. What it may ask of us is bounded, so that a run needs no gigabytes.
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "common/log.h"
#include "scenes/loader.h"
#include "tests/fuzz/target.h"

namespace gnomon::fuzz {
namespace {

class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "gnomon-fuzz-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) std::abort();
    path_ = name;
    log::set_level(log::Level::off);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace
}  // namespace gnomon::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace gnomon;
  static const fuzz::Folder folder;
  const bool binary = size >= 4 && data[0] == 'g' && data[1] == 'l';
  const auto file = folder.path() / (binary ? "scene.glb" : "scene.gltf");
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  scenes::LoadLimits limits;
  limits.max_file_bytes = 1 << 20;
  limits.max_triangles = 1 << 16;
  limits.max_instances = 1 << 10;
  limits.max_texels = 1 << 20;
  limits.base_memory_bytes = 1 << 22;
  if (const auto scene = scenes::load_scene(file, limits)) {
    fuzz::require((*scene)->triangle_count <= limits.max_triangles, "limits are kept");
  }
  return 0;
}
