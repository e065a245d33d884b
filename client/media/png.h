// RGBA pictures as PNG files. Only the implementation of this header uses libpng.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/result.h"

namespace gnomon::client {

// Rows from the top, four bytes a pixel.
struct Picture {
  uint32_t width = 0;
  uint32_t height = 0;
  std::vector<uint8_t> rgba;

  Picture() = default;
  Picture(uint32_t w, uint32_t h) : width(w), height(h), rgba(size_t{4} * w * h) {}
  uint8_t* pixel(uint32_t x, uint32_t y) { return &rgba[4 * (size_t{y} * width + x)]; }
  const uint8_t* pixel(uint32_t x, uint32_t y) const { return &rgba[4 * (size_t{y} * width + x)]; }
  friend bool operator==(const Picture&, const Picture&) = default;
};

// A borrowed picture, or part of one.
struct PictureView {
  uint32_t width = 0;
  uint32_t height = 0;
  size_t stride = 0;  // bytes from row to row
  const uint8_t* first = nullptr;

  const uint8_t* row(uint32_t y) const { return first + y * stride; }
};

Result<void> write_png(const std::filesystem::path& file, const Picture& picture);
Result<Picture> read_png(const std::filesystem::path& file);

}  // namespace gnomon::client
