// A glTF file in its parts: tinygltf reads the structure, this code reads the bytes. Internal to scenes/gltf/.
//
// tinygltf 2.7 is given neither buffers nor images: it copies a BIN chunk up to 8 bytes beyond the file's end, does not
// check the buffer views of images, opens any path that a URI names, and requires external buffers to be exactly as
// long as declared, where glTF allows longer ones.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "scenes/gltf/budget.h"
#include "scenes/gltf/folder.h"
#include "scenes/gltf/json_text.h"
#include "scenes/gltf/model.h"
#include "scenes/loader.h"
#include "scenes/scene.h"

namespace gnomon::scenes::gltf {

// The place of an image's bytes, which are read when a material needs them.
struct ImageSource {
  std::string uri;       // a data URI or a file; empty if the image lies in a buffer
  int buffer_view = -1;  // used if `uri` is empty
};

struct Document {
  Folder folder;
  tinygltf::Model model;                          // without the bytes of buffers and images
  std::vector<std::span<const uint8_t>> buffers;  // as long as declared, or empty where glTF allows no bytes
  std::vector<ImageSource> images;
  Extras extras;
  std::vector<Bytes> owned;  // the memory that `buffers` refers to
  mutable Budget budget;     // whoever makes something of the file announces it here first

  // The bytes of a buffer view. Error: the view or its buffer does not exist, or the view ends beyond its buffer.
  Result<std::span<const uint8_t>> view(int buffer_view) const;
  // Whether the view's buffer exists but has no bytes. That is legal, and everything read from it is zero.
  bool lacks_bytes(int buffer_view) const;
};

Result<Document> open_document(const std::filesystem::path& file, const LoadLimits& limits);

// The bytes of a data URI, or of a file in the scene's folder.
Result<Bytes> read_uri(Folder& folder, const std::string& uri, Budget& budget);

// Entry `index` of an array of the file. Error: "mesh 7 does not exist", where `what` is "mesh".
template <class T>
Result<const T*> entry(const std::vector<T>& array, int64_t index, const char* what) {
  if (index < 0 || static_cast<uint64_t>(index) >= array.size()) {
    return Error{std::string(what) + " " + std::to_string(index) + " does not exist"};
  }
  return &array[static_cast<size_t>(index)];
}

}  // namespace gnomon::scenes::gltf
