// Small glTF files made by tests: fill `root`, add bytes, write.
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "scenes/loader.h"

namespace gnomon::scenes::testing {

using json = nlohmann::json;

inline constexpr int kByte = 5120;
inline constexpr int kUnsignedByte = 5121;
inline constexpr int kShort = 5122;
inline constexpr int kUnsignedShort = 5123;
inline constexpr int kUnsignedInt = 5125;
inline constexpr int kFloat = 5126;

std::string base64(const std::vector<uint8_t>& bytes);

// A folder of its own for each object, removed with it.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path write(const std::string& name, const std::vector<uint8_t>& bytes) const;
  std::filesystem::path write(const std::string& name, const std::string& text) const;

 private:
  std::filesystem::path path_;
};

class GltfFile {
 public:
  json root = {{"asset", {{"version", "2.0"}}}};

  // Each gives the index of what it added.
  template <class T>
  int add_view(const std::vector<T>& values, int stride = 0) {
    return add_view_bytes(values.data(), values.size() * sizeof(T), stride);
  }
  template <class T>
  int add_accessor(const std::vector<T>& values, int component_type, const char* type) {
    const int view = add_view(values);
    return add(root["accessors"],
               {{"bufferView", view}, {"componentType", component_type}, {"type", type}, {"count", values.size()}});
  }
  int add_positions(const std::vector<glm::vec3>& positions) { return add_accessor(positions, kFloat, "VEC3"); }
  int add_mesh(const json& primitive) {
    return add(root["meshes"], json::object({{"primitives", json::array({primitive})}}));
  }
  int add_node(const json& node) { return add(root["nodes"], node); }
  int add_light(const json& light) { return add(root["extensions"]["KHR_lights_punctual"]["lights"], light); }
  // The node of a light.
  int add_lamp(const json& light, json node = json::object());

  static int add(json& array, const json& value) {
    array.push_back(value);
    return static_cast<int>(array.size()) - 1;
  }

  std::string gltf() const;  // with a data URI
  std::vector<uint8_t> glb() const;
  Result<ScenePtr> load() const;   // from a .gltf in a scratch folder
  ScenePtr load_or_fail() const;   // the same; a failure of the test where it cannot be loaded
  std::string load_error() const;  // "" where it loads

 private:
  int add_view_bytes(const void* data, size_t size, int stride);

  std::vector<uint8_t> bytes_;
};

// An animation of one property of one node.
template <class T>
void animate(GltfFile& file, int node, const char* path, const char* interpolation, const std::vector<float>& times,
             const std::vector<T>& values) {
  const int input = file.add_accessor(times, kFloat, "SCALAR");
  const int output = file.add_accessor(values, kFloat, sizeof(T) == 16 ? "VEC4" : "VEC3");
  const json sampler = {{"input", input}, {"output", output}, {"interpolation", interpolation}};
  const json channel = {{"sampler", 0}, {"target", {{"node", node}, {"path", path}}}};
  GltfFile::add(file.root["animations"],
                {{"samplers", json::array({sampler})}, {"channels", json::array({channel})}});
}

// One triangle (0,0,0) (1,0,0) (0,1,0) on node 0.
GltfFile triangle_file();

}  // namespace gnomon::scenes::testing
