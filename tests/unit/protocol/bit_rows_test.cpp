// What tiles_context looks up in bitmaps of several pixels at once, against looking at one pixel at a time.
#include "protocol/context/bit_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace gnomon::protocol::context {
namespace {

struct Bitmap {
  BitRows rows;

  // Beyond the edges that of the nearest pixel at an edge.
  bool lit(int x, int y) const {
    const int in_x = std::clamp(x, 0, rows.width() - 1), in_y = std::clamp(y, 0, rows.height() - 1);
    return (rows.get(in_x / 8, in_y / 8) >> (in_y % 8 * 8 + in_x % 8) & 1) != 0;
  }
  bool is_even(int x, int y, int side, bool value) const {
    for (int v = y; v < y + side; ++v)
      for (int u = x; u < x + side; ++u)
        if (lit(u, v) != value) return false;
    return true;
  }
};

// Mostly lit, with a dark rectangle and some single dark pixels.
Bitmap random_bitmap(std::mt19937& random, uint32_t tiles_x, uint32_t tiles_y) {
  Bitmap bitmap;
  bitmap.rows.reset(tiles_x, tiles_y);
  const auto below = [&](int end) { return static_cast<int>(random() % static_cast<uint32_t>(end)); };
  const int width = bitmap.rows.width(), height = bitmap.rows.height();
  const int left = below(width), top = below(height), right = left + below(width), bottom = top + below(height);
  for (int y = 0; y < height / 8; ++y)
    for (int x = 0; x < width / 8; ++x) {
      uint64_t word = 0;
      for (int bit = 0; bit < 64; ++bit) {
        const int u = x * 8 + bit % 8, v = y * 8 + bit / 8;
        const bool dark = (u >= left && u < right && v >= top && v < bottom) || random() % 500 == 0;
        word |= uint64_t{!dark} << bit;
      }
      bitmap.rows.put(x, y, word);
    }
  bitmap.rows.extend();
  return bitmap;
}

TEST(BitRows, WindowsShowThePixelsAndTheMarginsThoseAtTheEdges) {
  std::mt19937 random(1);
  for (const auto& [tiles_x, tiles_y] : {std::pair{1u, 1u}, std::pair{3u, 2u}, std::pair{17u, 5u}}) {
    const Bitmap bitmap = random_bitmap(random, tiles_x, tiles_y);
    const int width = bitmap.rows.width(), height = bitmap.rows.height();
    for (int y = -BitRows::kMarginRows; y < height + BitRows::kMarginRows; ++y)
      for (int x = -8 * BitRows::kMarginBytes; x < width + 56; ++x) {
        const uint32_t narrow = bitmap.rows.window(x, y);
        const uint64_t wide = bitmap.rows.wide_window(x, y);
        for (int i = 0; i < 64; ++i) ASSERT_EQ(wide >> i & 1, bitmap.lit(x + i, y)) << x << " + " << i << ", " << y;
        ASSERT_EQ(narrow, static_cast<uint32_t>(wide)) << x << ", " << y;
      }
  }
}

TEST(BitRows, SquaresAreEvenWhereAllTheirPixelsAre) {
  std::mt19937 random(2);
  int even = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const Bitmap bitmap = random_bitmap(random, 1 + random() % 20, 1 + random() % 9);
    for (int i = 0; i < 2000; ++i) {
      const int side = 1 + static_cast<int>(random() % 17);
      const auto place = [&](int size) {
        const int begin = -8 * BitRows::kMarginBytes, end = size + 8 * BitRows::kMarginBytes - side;
        return begin + static_cast<int>(random() % static_cast<uint32_t>(end - begin + 1));
      };
      const int x = place(bitmap.rows.width()), y = place(bitmap.rows.height());
      for (const bool lit : {false, true}) {
        ASSERT_EQ(bitmap.rows.is_even(x, y, side, lit), bitmap.is_even(x, y, side, lit))
            << x << ", " << y << ", side " << side << ", trial " << trial;
        even += bitmap.is_even(x, y, side, lit);
      }
    }
  }
  EXPECT_GT(even, 10'000);
}

}  // namespace
}  // namespace gnomon::protocol::context
