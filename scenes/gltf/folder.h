// Reads files of one folder and its subfolders only. Internal to scenes/gltf/.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/result.h"

namespace gnomon::scenes::gltf {

using Bytes = std::vector<uint8_t>;

// The folder of a scene file.
class Folder {
 public:
  // `max_bytes`: how much may be read through the object in all.
  static Result<Folder> of(const std::filesystem::path& file, uint64_t max_bytes);

  // Reads the scene file itself.
  Result<Bytes> read_scene_file();

  // `uri`: a relative reference of glTF, percent-encoded. Symbolic links are resolved first, and the resolved path must
  // lie within the folder. Only regular files are read, no devices and no pipes.
  Result<Bytes> read(const std::string& uri);

 private:
  Folder(std::filesystem::path file, uint64_t max_bytes) : file_(std::move(file)), bytes_left_(max_bytes) {}
  Result<Bytes> read_regular(const std::filesystem::path& file);

  std::filesystem::path file_;  // canonical
  uint64_t bytes_left_;
};

}  // namespace gnomon::scenes::gltf
