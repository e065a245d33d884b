// Reads files of one folder and never another's. Internal to scenes/gltf/.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/result.h"

namespace gnomon::scenes::gltf {

using Bytes = std::vector<uint8_t>;

// The folder of a scene file. `max_bytes` is what may be read through it in all.
class Folder {
 public:
  static Result<Folder> of(const std::filesystem::path& file, uint64_t max_bytes);

  // The scene file itself.
  Result<Bytes> read_scene_file();

  // A relative reference of glTF, percent-encoded. Symbolic links are followed first: what counts is where the file
  // really lies. Only regular files are read: no device, no pipe.
  Result<Bytes> read(const std::string& uri);

 private:
  Folder(std::filesystem::path file, uint64_t max_bytes) : file_(std::move(file)), bytes_left_(max_bytes) {}
  Result<Bytes> read_regular(const std::filesystem::path& file);

  std::filesystem::path file_;  // canonical
  uint64_t bytes_left_;
};

}  // namespace gnomon::scenes::gltf
