// A glTF file taken apart: its structure as tinygltf reads it, its bytes as we do. Internal to scenes/gltf/.
//
// tinygltf 2.7 gets neither buffers nor images to read: it copies a BIN chunk up to 8 bytes beyond the file's end,
// indexes the views of images unchecked, opens any path that a URI names, and wants external buffers exactly as long
// as declared where glTF allows longer ones.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "scenes/gltf/folder.h"
#include "scenes/gltf/model.h"
#include "scenes/loader.h"

namespace gnomon::scenes::gltf {

// Where an image's bytes are; not read before somebody needs it.
struct ImageSource {
  std::string uri;       // data or a file, or empty:
  int buffer_view = -1;  // bytes of a buffer
};

struct Document {
  Folder folder;
  tinygltf::Model model;                          // without the bytes of buffers and images
  std::vector<std::span<const uint8_t>> buffers;  // as long as declared, or without bytes where glTF lets them lack
  std::vector<ImageSource> images;
  std::vector<Bytes> owned;  // what `buffers` looks at
  // How many sparse elements may still be looked at: a file may name one large accessor again and again.
  mutable uint64_t sparse_left = uint64_t{1} << 28;

  // The bytes of a buffer view. Error: it or its buffer does not exist, or it ends beyond its buffer.
  Result<std::span<const uint8_t>> view(int buffer_view) const;
  // Whether the view's buffer exists but was left without bytes: legal, and everything read from it is zero.
  bool lacks_bytes(int buffer_view) const;
};

Result<Document> open_document(const std::filesystem::path& file, const LoadLimits& limits);

// The bytes of a data URI, or of a file in the scene's folder.
Result<Bytes> read_uri(Folder& folder, const std::string& uri);

// Entry `index` of an array of the file, or why not, as "mesh 7 does not exist".
template <class T>
Result<const T*> entry(const std::vector<T>& array, int64_t index, const char* what) {
  if (index < 0 || static_cast<uint64_t>(index) >= array.size()) {
    return Error{std::string(what) + " " + std::to_string(index) + " does not exist"};
  }
  return &array[static_cast<size_t>(index)];
}

}  // namespace gnomon::scenes::gltf
