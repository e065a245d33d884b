#include "scenes/gltf/image.h"

#include <climits>
#include <cstdlib>
#include <memory>
#include <string>

namespace {

// The largest block that stb_image may allocate while this thread decodes an image.
thread_local size_t largest_block = 0;

void* limited_malloc(size_t size) { return size <= largest_block ? std::malloc(size) : nullptr; }
void* limited_realloc(void* block, size_t size) {
  return size <= largest_block ? std::realloc(block, size) : nullptr;
}

}  // namespace

#define STBI_MALLOC(size) limited_malloc(size)
#define STBI_REALLOC(block, size) limited_realloc(block, size)
#define STBI_FREE(block) std::free(block)
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS 32768
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#include <stb/stb_image.h>

namespace gnomon::scenes::gltf {
namespace {

constexpr size_t kSlack = size_t{1} << 20;  // for tables, and for stb_image's initial buffers

// Pairs of bytes that begin a scan of a JPEG. Entropy-coded data has none; a thumbnail within the metadata may add one.
uint32_t scans_of(std::span<const uint8_t> bytes) {
  uint32_t count = 0;
  for (size_t i = 0; i + 1 < bytes.size(); ++i) count += bytes[i] == 0xff && bytes[i + 1] == 0xda;
  return count;
}

bool may_be_jpeg(std::span<const uint8_t> bytes) { return bytes[0] == 0xff; }

}  // namespace

Result<ImageHeader> read_image_header(std::span<const uint8_t> bytes) {
  if (bytes.empty() || bytes.size() > INT_MAX) return Error{"is empty or too large"};
  int width = 0;
  int height = 0;
  int channels = 0;
  largest_block = kSlack;
  const int size = static_cast<int>(bytes.size());
  if (stbi_info_from_memory(bytes.data(), size, &width, &height, &channels) == 0 || width <= 0 || height <= 0) {
    return Error{"is neither PNG nor JPEG"};
  }
  return ImageHeader{static_cast<uint32_t>(width), static_cast<uint32_t>(height),
                     may_be_jpeg(bytes) ? scans_of(bytes) : 0};
}

Result<Image> decode_image(std::span<const uint8_t> bytes, const ImageHeader& header) {
  const uint64_t texels = uint64_t{header.width} * header.height;
  int width = 0;
  int height = 0;
  int channels = 0;
  // 8 bytes per texel: 16 bits in four channels. stb_image doubles its buffer while it unpacks.
  largest_block = kSlack + 2 * (8 * texels + header.height) + bytes.size();
  const int size = static_cast<int>(bytes.size());
  const std::unique_ptr<stbi_uc, decltype(&std::free)> texel_bytes(
      stbi_load_from_memory(bytes.data(), size, &width, &height, &channels, 4), &std::free);
  if (!texel_bytes) return Error{std::string("cannot be decoded: ") + stbi_failure_reason()};
  Image image{header.width, header.height, {}};
  image.rgba.assign(texel_bytes.get(), texel_bytes.get() + 4 * texels);
  return image;
}

}  // namespace gnomon::scenes::gltf
