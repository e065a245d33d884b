#include "tests/unit/scenes/support/gltf_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <fstream>

namespace gnomon::scenes::testing {
namespace {

void put_u32(std::vector<uint8_t>& out, size_t value) {
  for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<uint8_t>(value >> shift));
}

void put_chunk(std::vector<uint8_t>& out, uint32_t type, const std::vector<uint8_t>& content, uint8_t padding) {
  const size_t padded = (content.size() + 3) & ~size_t{3};
  put_u32(out, padded);
  put_u32(out, type);
  out.insert(out.end(), content.begin(), content.end());
  out.insert(out.end(), padded - content.size(), padding);
}

}  // namespace

std::string base64(const std::vector<uint8_t>& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const size_t count = std::min<size_t>(3, bytes.size() - i);
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k) group = group << 8 | (k < count ? bytes[i + k] : 0u);
    for (size_t k = 0; k < 4; ++k) out += k <= count ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

ScratchFolder::ScratchFolder() {
  static std::atomic<int> next = 0;
  path_ = std::filesystem::path(::testing::TempDir()) /
          ("gnomon_scenes_" + std::to_string(getpid()) + "_" + std::to_string(next++));
  std::filesystem::create_directories(path_);
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::filesystem::path ScratchFolder::write(const std::string& name, const std::vector<uint8_t>& bytes) const {
  const std::filesystem::path file = path_ / name;
  std::filesystem::remove(file);  // file systems flush what is written over an old file
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return file;
}

std::filesystem::path ScratchFolder::write(const std::string& name, const std::string& text) const {
  return write(name, std::vector<uint8_t>(text.begin(), text.end()));
}

int GltfFile::add_lamp(const json& light, json node) {
  node["extensions"]["KHR_lights_punctual"]["light"] = add_light(light);
  return add_node(node);
}

int GltfFile::add_view_bytes(const void* data, size_t size, int stride) {
  bytes_.resize((bytes_.size() + 3) & ~size_t{3});
  json view = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", size}};
  if (stride != 0) view["byteStride"] = stride;
  const auto* from = static_cast<const uint8_t*>(data);
  bytes_.insert(bytes_.end(), from, from + size);
  return add(root["bufferViews"], view);
}

std::string GltfFile::gltf() const {
  json out = root;
  if (!bytes_.empty()) {
    const std::string uri = "data:application/octet-stream;base64," + base64(bytes_);
    out["buffers"] = json::array({json::object({{"byteLength", bytes_.size()}, {"uri", uri}})});
  }
  return out.dump();
}

std::vector<uint8_t> GltfFile::glb() const {
  json with_buffer = root;
  if (!bytes_.empty()) with_buffer["buffers"] = json::array({json::object({{"byteLength", bytes_.size()}})});
  const std::string text = with_buffer.dump();
  std::vector<uint8_t> chunks;
  put_chunk(chunks, 0x4e4f534a, std::vector<uint8_t>(text.begin(), text.end()), ' ');
  if (!bytes_.empty()) put_chunk(chunks, 0x004e4942, bytes_, 0);
  std::vector<uint8_t> out = {'g', 'l', 'T', 'F'};
  put_u32(out, 2);
  put_u32(out, 12 + chunks.size());
  out.insert(out.end(), chunks.begin(), chunks.end());
  return out;
}

Result<ScenePtr> GltfFile::load() const {
  const ScratchFolder folder;
  return load_scene(folder.write("scene.gltf", gltf()));
}

ScenePtr GltfFile::load_or_fail() const {
  const Result<ScenePtr> scene = load();
  if (scene) return *scene;
  ADD_FAILURE() << scene.error().message;
  auto empty = std::make_shared<Scene>();
  empty->materials.emplace_back();
  empty->cameras.emplace_back();
  return empty;
}

std::string GltfFile::load_error() const {
  const Result<ScenePtr> scene = load();
  return scene ? std::string() : scene.error().message;
}

GltfFile triangle_file() {
  GltfFile file;
  const int positions = file.add_positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  file.add_node({{"mesh", file.add_mesh({{"attributes", {{"POSITION", positions}}}})}});
  return file;
}

}  // namespace gnomon::scenes::testing
