// A frame of tiles_lz4 in bands, which several threads encode.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <thread>

#include "protocol/band_plan.h"
#include "protocol/split_frame.h"
#include "tests/unit/protocol/masks.h"

namespace gnomon::protocol {
namespace {

using tests::Mask;

// Some tiles matter in whole, some in part and some not at all, in runs.
PackedMask packed(const Mask& mask, uint32_t seed) {
  std::mt19937_64 random(seed);
  std::vector<uint64_t> care(mask.words.size());
  uint64_t of_run = 0;
  for (uint64_t& word : care) {
    if (random() % 20 == 0) of_run = random() % 3 == 0 ? 0 : ~uint64_t{0};
    word = random() % 7 == 0 ? random() : of_run;
  }
  return PackedMask(mask.view(), care);
}

uint32_t mixed_in(const PackedMaskView& mask, size_t first, size_t end) {
  uint32_t mixed = 0;
  for (size_t word = first; word < end; ++word) mixed += mask.class_of(word) == PackedClass::mixed;
  return mixed;
}

TEST(Bands, HoldEveryRowOnceAndAboutAsManyMixedTilesEach) {
  const Mask mask = tests::foliage({1920, 1080, 8}, 1);
  const PackedMask of(mask.view(), std::vector<uint64_t>(mask.words.size(), ~uint64_t{0}));
  BandPlan plan;
  plan.plan(of.view());
  ASSERT_GT(plan.band_count(), 3u);
  uint32_t row = 0;
  const size_t tiles_x = mask.grid.tiles_x();
  for (size_t band = 0; band < plan.band_count(); ++band) {
    EXPECT_EQ(plan.rows(band).first, row);
    size_t mixed = 0;
    for (uint32_t plane = 0; plane < mask.grid.planes; ++plane) {
      const size_t first = size_t{plane} * mask.grid.tile_count() + row * tiles_x;
      EXPECT_EQ(plan.mixed_before(plane, row), mixed_in(of.view(), 0, first));
      mixed += mixed_in(of.view(), first, first + plan.rows(band).count * tiles_x);
    }
    EXPECT_LT(mixed * plan.band_count(), of.view().mixed.size() * 3 / 2);
    row = plan.rows(band).end();
  }
  EXPECT_EQ(row, mask.grid.tiles_y());
}

TEST(Bands, AreTheSameOfTheWordsThatAFrameUnpacksTo) {
  for (const Mask& mask :
       {tests::foliage({1280, 720, 5}, 2), tests::noise({417, 333, 3}, 3), tests::room({90, 40, 2}, 4)}) {
    const PackedMask of = packed(mask, 5);
    const std::vector<uint64_t> words = unpacked(of.view());
    BandPlan of_packed, of_words;
    of_packed.plan(of.view());
    of_words.plan(TileMaskView{mask.grid, words});
    ASSERT_EQ(of_packed.band_count(), of_words.band_count());
    for (size_t band = 0; band < of_packed.band_count(); ++band) {
      EXPECT_EQ(of_packed.rows(band), of_words.rows(band));
      for (uint32_t plane = 0; plane < mask.grid.planes; ++plane) {
        const uint32_t row = of_packed.rows(band).first;
        EXPECT_EQ(of_packed.mixed_before(plane, row), of_words.mixed_before(plane, row));
      }
    }
  }
}

TEST(Bands, AFrameOfFewMixedTilesIsOneAndOneWithoutLightsNone) {
  BandPlan plan;
  plan.plan(tests::room({640, 360, 1}, 1).view());
  EXPECT_EQ(plan.band_count(), 1u);
  plan.plan(tests::all_dark({640, 360, 0}).view());
  EXPECT_EQ(plan.band_count(), 0u);
}

// Bands that threads encode in any order join to what one thread makes, and decode to the frame.
TEST(Bands, JoinToTheFrame) {
  for (const Mask& mask : {tests::foliage({1920, 1080, 8}, 1), tests::noise({700, 411, 5}, 2),
                           tests::noise({1000, 8, 40}, 3), tests::room({90, 40, 2}, 4)}) {
    const PackedMask of = packed(mask, 6);
    SplitFrame split = SplitFrame::of_bands(of.view(), kMaxSlicePayloadBytes);
    std::vector<std::thread> threads;
    for (size_t unit = split.unit_count(); unit-- > 0;)
      threads.emplace_back([&split, unit] { split.encode(unit); });
    for (std::thread& thread : threads) thread.join();
    EncodedMask joined, whole;
    ASSERT_TRUE(split.join(joined));
    ASSERT_TRUE(FrameEncoder().encode(of.view(), CodecId::tiles_lz4, kMaxSlicePayloadBytes, whole));
    EXPECT_EQ(joined.slices, whole.slices);
    EXPECT_EQ(joined.bytes, whole.bytes);
    EXPECT_EQ(joined.offsets, whole.offsets);

    std::vector<uint64_t> words(mask.words.size());
    for (size_t i = joined.slices.size(); i-- > 0;)
      ASSERT_TRUE(decode_slice(joined.slices[i], joined.payload(i), mask.grid, words));
    EXPECT_TRUE(words == unpacked(of.view()));
  }
}

}  // namespace
}  // namespace gnomon::protocol
