// Decodes the images that glTF allows: PNG and JPEG. Only its implementation uses stb_image. Internal to scenes/gltf/.
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

// The size in the image's header is checked against `max_texels` before anything is decoded, and each allocation of the
// decoder is limited by that size, because a few bytes of a PNG can unpack to gigabytes. Error: the data is neither PNG
// nor JPEG, is damaged, or exceeds `max_texels`.
Result<Image> decode_image(std::span<const uint8_t> bytes, uint64_t max_texels);

}  // namespace gnomon::scenes::gltf
