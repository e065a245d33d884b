#include "tests/unit/scenes/support/png.h"

#include <cstdlib>
#include <string>

#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STBI_WRITE_NO_STDIO
#include <stb/stb_image_write.h>

namespace gnomon::scenes::testing {
namespace {

void append(void* out, void* data, int size) {
  auto& bytes = *static_cast<std::vector<uint8_t>*>(out);
  const auto* from = static_cast<const uint8_t*>(data);
  bytes.insert(bytes.end(), from, from + size);
}

void put_u32(std::vector<uint8_t>& out, uint32_t v) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<uint8_t>(v >> shift));
}

// stb_image reads over checksums without looking.
void put_chunk(std::vector<uint8_t>& out, const std::string& type, const std::vector<uint8_t>& content) {
  put_u32(out, static_cast<uint32_t>(content.size()));
  out.insert(out.end(), type.begin(), type.end());
  out.insert(out.end(), content.begin(), content.end());
  put_u32(out, 0);
}

}  // namespace

std::vector<uint8_t> png(uint32_t width, uint32_t height, const std::vector<uint8_t>& rgba) {
  std::vector<uint8_t> out;
  stbi_write_png_to_func(append, &out, static_cast<int>(width), static_cast<int>(height), 4, rgba.data(),
                         static_cast<int>(4 * width));
  return out;
}

std::vector<uint8_t> png_bomb(size_t unpacked_bytes) {
  std::vector<uint8_t> zeros(unpacked_bytes, 0);
  int size = 0;
  unsigned char* packed = stbi_zlib_compress(zeros.data(), static_cast<int>(zeros.size()), &size, 5);
  const std::vector<uint8_t> content(packed, packed + size);
  std::free(packed);
  std::vector<uint8_t> out = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  put_chunk(out, "IHDR", {0, 0, 0, 1, 0, 0, 0, 1, 8, 6, 0, 0, 0});
  put_chunk(out, "IDAT", content);
  put_chunk(out, "IEND", {});
  return out;
}

}  // namespace gnomon::scenes::testing
