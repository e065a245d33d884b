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

// What an image says of itself.
struct ImageHeader {
  uint32_t width = 0;
  uint32_t height = 0;
  uint32_t scans = 0;  // of a JPEG, or more: whatever looks like the beginning of one counts
};

// Decodes nothing. Error: the data is neither PNG nor JPEG.
Result<ImageHeader> read_image_header(std::span<const uint8_t> bytes);

// `header`: of the same bytes; whoever calls has found that it may be decoded. Each allocation of the decoder is limited
// by that size, because a few bytes of a PNG can unpack to gigabytes. Error: the data is damaged.
Result<Image> decode_image(std::span<const uint8_t> bytes, const ImageHeader& header);

}  // namespace gnomon::scenes::gltf
