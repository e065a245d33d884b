// Decodes the images that glTF allows: PNG and JPEG. stb_image stands behind this header alone. Internal to
// scenes/gltf/.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/result.h"

namespace gnomon::scenes::gltf {

struct Image {
  uint32_t width = 0;
  uint32_t height = 0;
  std::vector<uint8_t> rgba;  // 8 bits, rows from the top
};

// Size comes from the header and is checked against `max_texels` before anything is decoded; no step of decoding may
// take more memory than an image of that size explains (a few bytes of a PNG can unpack to gigabytes).
Result<Image> decode_image(std::span<const uint8_t> bytes, uint64_t max_texels);

}  // namespace gnomon::scenes::gltf
