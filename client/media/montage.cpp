#include "client/media/montage.h"

#include <algorithm>
#include <cassert>
#include <cstdlib>
#include <cstring>

#include "client/media/label.h"

namespace gnomon::client {
namespace {

constexpr uint32_t kGap = 4;              // pixels between panels
constexpr uint32_t kPanelsPerColumn = 4;  // for 4 to 16 panels; more make more rows of smaller ones
constexpr uint8_t kBackground = 24;

// Each pixel is the mean of the pixels that fall into it.
Picture scale_down(const Picture& from, uint32_t width, uint32_t height) {
  Picture to(width, height);
  for (uint32_t y = 0; y < height; ++y) {
    const uint32_t y0 = y * from.height / height;
    const uint32_t y1 = std::max(y0 + 1, (y + 1) * from.height / height);
    for (uint32_t x = 0; x < width; ++x) {
      const uint32_t x0 = x * from.width / width;
      const uint32_t x1 = std::max(x0 + 1, (x + 1) * from.width / width);
      const uint32_t count = (y1 - y0) * (x1 - x0);
      for (uint32_t channel = 0; channel < 4; ++channel) {
        uint32_t sum = 0;
        for (uint32_t v = y0; v < y1; ++v) {
          for (uint32_t u = x0; u < x1; ++u) sum += from.pixel(u, v)[channel];
        }
        to.pixel(x, y)[channel] = static_cast<uint8_t>((sum + count / 2) / count);
      }
    }
  }
  return to;
}

void paste(const Picture& from, Picture& to, uint32_t left, uint32_t top) {
  for (uint32_t y = 0; y < from.height; ++y) {
    std::memcpy(to.pixel(left, top + y), from.pixel(0, y), size_t{4} * from.width);
  }
}

Picture background(uint32_t width, uint32_t height) {
  Picture picture(width, height);
  for (size_t i = 0; i < picture.rgba.size(); ++i) picture.rgba[i] = i % 4 == 3 ? 255 : kBackground;
  return picture;
}

}  // namespace

Picture copied(const PictureView& view) {
  Picture picture(view.width, view.height);
  for (uint32_t y = 0; y < view.height; ++y) std::memcpy(picture.pixel(0, y), view.row(y), size_t{4} * view.width);
  return picture;
}

Picture crop(const Picture& whole, uint32_t left, uint32_t top, uint32_t width, uint32_t height) {
  const PictureView view{whole.width, whole.height, size_t{4} * whole.width, whole.rgba.data()};
  return copied(crop(view, left, top, width, height));
}

PictureView crop(const PictureView& whole, uint32_t left, uint32_t top, uint32_t width, uint32_t height) {
  assert(left + width <= whole.width && top + height <= whole.height);
  return {width, height, whole.stride, whole.row(top) + size_t{4} * left};
}

Picture beside(const Picture& left, const Picture& right) {
  assert(left.height == right.height);
  Picture both = background(left.width + kGap + right.width, left.height);
  paste(left, both, 0, 0);
  paste(right, both, left.width + kGap, 0);
  return both;
}

Picture difference(const Picture& a, const Picture& b, uint32_t gain) {
  assert(a.width == b.width && a.height == b.height);
  Picture off(a.width, a.height);
  for (size_t i = 0; i < off.rgba.size(); ++i) {
    const auto by = static_cast<uint32_t>(std::abs(int{a.rgba[i]} - int{b.rgba[i]}));
    off.rgba[i] = i % 4 == 3 ? 255 : static_cast<uint8_t>(std::min(255u, gain * by));
  }
  return off;
}

Picture montage(const std::vector<Picture>& panels, const Picture& shaded, const std::vector<std::string>& names) {
  if (panels.empty()) return shaded;
  const auto count = static_cast<uint32_t>(panels.size());
  // Enough rows that the panels' columns are not wider than the picture beside them.
  uint32_t rows = std::min(count, kPanelsPerColumn);
  while ((count + rows - 1) / rows > rows) ++rows;
  const uint32_t columns = (count + rows - 1) / rows;
  const uint32_t panel_height = std::max(1u, (shaded.height - std::min(shaded.height, kGap * (rows - 1))) / rows);
  const uint32_t panel_width = std::max(1u, panel_height * shaded.width / shaded.height);

  Picture whole = background(columns * (panel_width + kGap) + shaded.width,
                             std::max(shaded.height, rows * (panel_height + kGap) - kGap));
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t left = i / rows * (panel_width + kGap), top = i % rows * (panel_height + kGap);
    paste(scale_down(panels[i], panel_width, panel_height), whole, left, top);
    if (i < names.size())
      write_label(whole, left, top, left + panel_width, names[i], label_scale(2 * panel_height));
  }
  paste(shaded, whole, columns * (panel_width + kGap), 0);
  return whole;
}

}  // namespace gnomon::client
