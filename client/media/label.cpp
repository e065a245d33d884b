#include "client/media/label.h"

#include <algorithm>
#include <array>
#include <cstring>

// stb_easy_font is C code with warnings of its own.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wsign-compare"
#include <stb/stb_easy_font.h>
#pragma GCC diagnostic pop

namespace gnomon::client {
namespace {

constexpr uint32_t kMargin = 3;  // pixels of the ground around the letters, before scaling
constexpr uint32_t kLetterHeight = 9;

// A corner as stb_easy_font writes it.
struct Corner {
  float x, y, z;
  uint32_t colour;
};

struct Box {
  uint32_t left, top, right, bottom;
};

void fill(Picture& picture, const Box& box, uint8_t value, uint32_t opacity) {
  for (uint32_t y = box.top; y < std::min(box.bottom, picture.height); ++y) {
    for (uint32_t x = box.left; x < std::min(box.right, picture.width); ++x) {
      uint8_t* pixel = picture.pixel(x, y);
      for (int i = 0; i < 3; ++i) {
        pixel[i] = static_cast<uint8_t>((pixel[i] * (255 - opacity) + value * opacity) / 255);
      }
    }
  }
}

}  // namespace

void write_label(Picture& picture, uint32_t left, uint32_t top, uint32_t right, const std::string& text,
                 uint32_t scale) {
  std::string line = text.substr(0, 80);
  const auto has_no_letter = [](char c) { return c < ' ' || c > '~'; };  // the font's table ends there
  std::replace_if(line.begin(), line.end(), has_no_letter, '?');
  std::array<Corner, 4 * 2000> corners;
  const int quads = stb_easy_font_print(0.0f, 0.0f, line.data(), nullptr, corners.data(), sizeof corners);
  const auto width = static_cast<uint32_t>(stb_easy_font_width(line.data()));
  right = std::min(right, picture.width);
  fill(picture,
       {left, top, std::min(left + scale * (width + 2 * kMargin), right),
        top + scale * (kLetterHeight + 2 * kMargin)},
       16, 190);
  for (size_t quad = 0; quad < static_cast<size_t>(quads); ++quad) {
    const Corner &low = corners[4 * quad], &high = corners[4 * quad + 2];
    const auto across = [&](float x) {
      return std::min(left + scale * (kMargin + static_cast<uint32_t>(x)), right);
    };
    const auto down = [&](float y) { return top + scale * (kMargin + static_cast<uint32_t>(y)); };
    fill(picture, {across(low.x), down(low.y), across(high.x), down(high.y)}, 245, 255);
  }
}

}  // namespace gnomon::client
