// Reads files of one folder and its subfolders only. Internal to scenes/gltf/.
#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/result.h"
#include "scenes/gltf/budget.h"

namespace gnomon::scenes::gltf {

using Bytes = std::vector<uint8_t>;

// The folder of a scene file. What is read counts as the scene's size; a file that is read again is memory that the
// scene takes.
class Folder {
 public:
  static Result<Folder> of(const std::filesystem::path& file);

  // Reads the scene file itself.
  Result<Bytes> read_scene_file(Budget& budget);

  // `uri`: a relative reference of glTF, percent-encoded. Symbolic links are resolved first, and the resolved path must
  // lie within the folder. Only regular files are read, no devices and no pipes.
  Result<Bytes> read(const std::string& uri, Budget& budget);

 private:
  explicit Folder(std::filesystem::path file) : file_(std::move(file)) {}
  Result<Bytes> read_regular(const std::filesystem::path& file, Budget& budget);

  std::filesystem::path file_;                    // canonical
  std::set<std::pair<uint64_t, uint64_t>> seen_;  // files that were read, by device and inode: names cost nothing
};

}  // namespace gnomon::scenes::gltf
