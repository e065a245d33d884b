// Mip levels: how many there are, and that each keeps the light of the one before.
#include "gpu/scene/texels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace gnomon::test {
namespace {

using gpu::Texels;

scenes::Texture checks(uint32_t width, uint32_t height) {
  scenes::Texture texture;
  texture.width = width, texture.height = height;
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      const uint8_t value = (x + y) % 2 ? 255 : 0;
      texture.rgba.insert(texture.rgba.end(), {value, value, 255, 200});
    }
  }
  return texture;
}

double linear(uint32_t texel, int channel) {
  const double root = ((texel >> (8 * channel)) & 255) / 255.0;
  return root * root;
}

TEST(Texels, LevelsGoDownToOneTexelOfTheMeanLight) {
  const Texels texels = gpu::mipmapped_texels(checks(8, 4));
  EXPECT_EQ(texels.levels, 4u);
  ASSERT_EQ(texels.rgba.size(), 8u * 4 + 4 * 2 + 2 * 1 + 1);
  const uint32_t last = texels.rgba.back();
  // Half of the light, not half of the sRGB value, which would be 0.21.
  EXPECT_NEAR(linear(last, 0), 0.5, 0.005);
  EXPECT_NEAR(linear(last, 2), 1.0, 0.005);
  EXPECT_EQ(last >> 24, 200u);
}

TEST(Texels, LevelZeroIsTheSameWithAndWithoutLevels) {
  scenes::Texture texture = checks(16, 16);
  for (size_t i = 0; i < texture.rgba.size(); ++i) texture.rgba[i] = static_cast<uint8_t>(i * 31 % 256);
  const Texels flat = gpu::flat_texels(texture), levels = gpu::mipmapped_texels(texture);
  ASSERT_EQ(flat.rgba.size(), 256u);
  EXPECT_TRUE(std::equal(flat.rgba.begin(), flat.rgba.end(), levels.rgba.begin()));
  EXPECT_NEAR(linear(flat.rgba[0], 1), std::pow((31 / 255.0 + 0.055) / 1.055, 2.4), 0.0005);
}

TEST(Texels, OddSizesAreRoundedDown) {
  EXPECT_EQ(gpu::mipmapped_texels(checks(5, 3)).rgba.size(), 5u * 3 + 2 * 1 + 1);
  EXPECT_EQ(gpu::mipmapped_texels(checks(1, 1)).levels, 1u);
}

TEST(Texels, AlphaIsAsInTheFile) {
  scenes::Texture texture = checks(3, 3);
  for (size_t i = 0; i < 9; ++i) texture.rgba[4 * i + 3] = static_cast<uint8_t>(28 * i);
  const Texels flat = gpu::flat_texels(texture);
  ASSERT_EQ(flat.rgba.size(), 9u);
  for (size_t i = 0; i < 9; ++i) EXPECT_EQ(flat.rgba[i] >> 24, 28 * i);
}

}  // namespace
}  // namespace gnomon::test
