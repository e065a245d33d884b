// Prediction errors against bits counted by hand.
#include "client/prediction/prediction_error.h"

#include <gtest/gtest.h>

#include "tests/unit/protocol/masks.h"

namespace gnomon::client {
namespace {

constexpr TileGrid kGrid{21, 13, 3};

TEST(LightBits, AreTheMasksBits) {
  const tests::Mask mask = tests::noise(kGrid, 1);
  const LightBits bits(mask.view());
  for (uint32_t y = 0; y < kGrid.height; ++y)
    for (uint32_t x = 0; x < kGrid.width; ++x)
      for (uint32_t light = 0; light < kGrid.planes; ++light)
        ASSERT_EQ(bits.pixels[size_t{y} * kGrid.width + x] >> light & 1, mask.view().lit(x, y, light));
}

// A picture of 2x1 pixels in the middle of a fresh one of 4x1, predicted from three pixels of another.
struct Little {
  LightBits seen, fresh;
  std::vector<uint32_t> care{0, 0b11, 0b01, 0};

  Little() {
    seen.width = 3, seen.height = 1, seen.lights = 2, seen.pixels = {0b00, 0b01, 0b11};
    fresh.width = 4, fresh.height = 1, fresh.lights = 2, fresh.pixels = {0b00, 0b01, 0b10, 0b00};
  }
  PredictionError of(std::vector<uint32_t> sources, PixelRect traced, bool with_care = true) const {
    return compare(seen, sources, traced, fresh,
                   with_care ? std::span<const uint32_t>(care) : std::span<const uint32_t>(), {1, 0, 2, 1});
  }
};

TEST(PredictionError, CountsBitsThatMatter) {
  const Little little;
  const PredictionError right = little.of({2, 1}, {0, 0, 3, 1});  // 01 of 01; 00 of 10, where the first bit matters
  EXPECT_EQ(right.bits, 3u);
  EXPECT_EQ(right.wrong, 0u);
  EXPECT_EQ(right.pixels, 2u);
  const PredictionError dark = little.of({1, 1}, {0, 0, 3, 1});
  EXPECT_EQ(dark.wrong, 1u);
  EXPECT_EQ(dark.falsely_dark, 1u);
  EXPECT_DOUBLE_EQ(dark.share(), 1.0 / 3);
  EXPECT_DOUBLE_EQ(dark.per_light(2), 0.5);
  EXPECT_DOUBLE_EQ(dark.share_of_picture(2), 0.25);
}

TEST(PredictionError, WhatWasNotTracedIsLit) {
  const Little little;
  for (const PredictionError& error : {little.of({0, 0}, {0, 0, 3, 1}), little.of({1, 1}, {1, 0, 2, 1})}) {
    EXPECT_EQ(error.wrong, 2u);
    EXPECT_EQ(error.falsely_dark, 0u);
  }
}

TEST(PredictionError, WithoutCareEveryBitOfWhatWasFoundCounts) {
  const Little little;
  EXPECT_EQ(little.of({2, 1}, {0, 0, 3, 1}, false).bits, 4u);
  EXPECT_EQ(little.of({2, 1}, {0, 0, 3, 1}, false).wrong, 1u);
  EXPECT_EQ(little.of({2, 0}, {0, 0, 3, 1}, false).bits, 2u);
}

// With a step of 1 the count is that of all pixels; with a larger one it stays within the picture.
TEST(PredictionError, OfSomePixelsIsAnEstimate) {
  const tests::Mask seen = tests::noise(kGrid, 2), fresh = tests::noise(kGrid, 3);
  const PixelRect shown{2, 1, 17, 9};
  std::vector<uint32_t> sources;
  for (uint32_t i = 0; i < shown.width * shown.height; ++i) sources.push_back(i * 7 % (kGrid.width * kGrid.height));
  const PredictionError all = compare(LightBits(seen.view()), sources, {0, 0, kGrid.width, kGrid.height},
                                      LightBits(fresh.view()), {}, shown);
  const PredictionError same = compare_some(seen.view(), sources, fresh.view(), shown, 1);
  EXPECT_EQ(same.pixels, all.pixels);
  EXPECT_EQ(same.bits, all.bits);
  EXPECT_EQ(same.wrong, all.wrong);
  EXPECT_EQ(same.falsely_dark, all.falsely_dark);
  const PredictionError some = compare_some(seen.view(), sources, fresh.view(), shown, 4);
  EXPECT_EQ(some.pixels, 5u * 3u);
  EXPECT_LE(some.bits, some.pixels * kGrid.planes);
  EXPECT_GT(some.wrong, 0u);
}

// Counts that are one point apart are one wrong of k, however many bits of the number differ.
TEST(PredictionError, OfAreaLightsIsByTheirPoints) {
  const LightPlanes planes({true}, 16);
  const TileGrid grid{8, 8, planes.total()};
  const auto all_see = [&](uint32_t number) {
    return tests::make_mask(grid, [=](uint32_t, uint32_t, uint32_t plane) {
      return plane == 0 ? number == 16 : number == 16 || (number >> (4 - plane) & 1) != 0;
    });
  };
  const std::vector<uint32_t> sources{1};
  const auto error = [&](uint32_t said, uint32_t is) {
    return compare_some(all_see(said).view(), sources, all_see(is).view(), {0, 0, 1, 1}, 1, planes);
  };
  EXPECT_EQ(error(7, 8).bits, 16u);
  EXPECT_EQ(error(7, 8).wrong, 1u);
  EXPECT_EQ(error(7, 8).falsely_dark, 1u);
  EXPECT_EQ(error(16, 12).wrong, 4u);
  EXPECT_EQ(error(16, 12).falsely_dark, 0u);
  EXPECT_EQ(error(0, 16).wrong, 16u);
}

}  // namespace
}  // namespace gnomon::client
