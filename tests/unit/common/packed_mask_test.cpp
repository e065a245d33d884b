#include "common/packed_mask.h"

#include <gtest/gtest.h>

#include <bit>
#include <optional>
#include <random>

namespace gnomon::test {
namespace {

// Words like a renderer's: uniform ones, borders and noise; and whether they matter in whole, in part or not.
struct Frame {
  TileGrid grid;
  std::vector<uint64_t> words, valid_bits;

  TileMaskView mask() const { return {grid, words}; }
};

uint64_t some_word(std::mt19937_64& random) {
  switch (random() % 5) {
    case 0: return 0;
    case 1: return ~uint64_t{0};
    case 2: return ~uint64_t{0} << random() % 64;
    case 3: return 0x0101010101010101 * (random() & 0xff);
    default: return random();
  }
}

Frame random_frame(std::mt19937_64& random) {
  const auto side = [&] { return static_cast<uint32_t>(1 + random() % 150); };
  Frame frame{{side(), side(), static_cast<uint32_t>(random() % 6)}, {}, {}};
  for (size_t i = 0; i < frame.grid.word_count(); ++i) {
    frame.valid_bits.push_back(some_word(random) | some_word(random));
    if (random() % 3 == 0) frame.valid_bits.back() = 0;
    frame.words.push_back(some_word(random));
  }
  return frame;
}

TEST(PackedMask, KeepsEveryBitThatMatters) {
  std::mt19937_64 random(1);
  size_t mattering = 0;
  for (int i = 0; i < 300; ++i) {
    const Frame frame = random_frame(random);
    const PackedMask packed(frame.mask(), frame.valid_bits);
    const std::vector<uint64_t> words = unpacked(packed.view());
    ASSERT_EQ(words.size(), frame.words.size());
    for (size_t w = 0; w < words.size(); ++w) {
      ASSERT_EQ((words[w] ^ frame.words[w]) & frame.valid_bits[w], 0u) << "frame " << i << ", word " << w;
      mattering += static_cast<size_t>(std::popcount(frame.valid_bits[w]));
    }
  }
  EXPECT_GT(mattering, 100000u);
}

TEST(PackedMask, OnlyTilesWithBothValuesAreMixed) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 100; ++i) {
    const Frame frame = random_frame(random);
    const PackedMask packed(frame.mask(), frame.valid_bits);
    const PackedMaskView view = packed.view();
    size_t mixed = 0;
    for (size_t w = 0; w < frame.words.size(); ++w) {
      const uint64_t lit = frame.words[w] & frame.valid_bits[w], dark = ~frame.words[w] & frame.valid_bits[w];
      const PackedClass expected = lit && dark ? PackedClass::mixed
                                   : lit       ? PackedClass::lit
                                   : dark      ? PackedClass::dark
                                               : PackedClass::free;
      ASSERT_EQ(view.class_of(w), expected) << "word " << w;
      mixed += expected == PackedClass::mixed;
    }
    EXPECT_EQ(view.mixed.size(), mixed);
    EXPECT_EQ(view.bytes(), (frame.words.size() + 15) / 16 * 4 + mixed * 8);
  }
}

// The rule as its words say it, bit by bit.
std::optional<bool> nearest_in_column(uint64_t lit, uint64_t care, int column, int row) {
  const auto bit = [&](int r) { return uint64_t{1} << (8 * r + column); };
  for (int r = row; r >= 0; --r)
    if (care & bit(r)) return (lit & bit(r)) != 0;
  for (int r = row + 1; r < 8; ++r)
    if (care & bit(r)) return (lit & bit(r)) != 0;
  return {};
}

uint64_t filled_slowly(uint64_t lit, uint64_t care) {
  uint64_t word = 0;
  for (int row = 0; row < 8; ++row)
    for (int column = 0; column < 8; ++column) {
      std::optional<bool> value;
      for (int c = column; c >= 0 && !value; --c) value = nearest_in_column(lit, care, c, row);
      for (int c = column + 1; c < 8 && !value; ++c) value = nearest_in_column(lit, care, c, row);
      if (value.value_or(false)) word |= uint64_t{1} << (8 * row + column);
    }
  return word;
}

TEST(PackedMask, FillsByItsRule) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 20000; ++i) {
    const uint64_t lit = some_word(random), care = some_word(random) & some_word(random) & random();
    ASSERT_EQ(filled(lit, care), filled_slowly(lit, care)) << std::hex << lit << ' ' << care;
  }
  EXPECT_EQ(filled(0x0f, 0xff), 0x0f0f0f0f0f0f0f0fu);
  EXPECT_EQ(filled(~uint64_t{0}, 0), 0u);
}

TEST(PackedMask, FreeTilesFollowTheLastUniformOneOfTheirLight) {
  const uint64_t lit = ~uint64_t{0}, mixed = 0xff;
  // Two lights of five tiles: free, lit, free, mixed, free; then free, dark, free, lit, free.
  const Frame frame{{40, 8, 2}, {0, lit, 0, mixed, 0, 0, 0, 0, lit, 0}, {0, lit, 0, lit, 0, 0, lit, 0, lit, 0}};
  const PackedMask packed(frame.mask(), frame.valid_bits);
  EXPECT_EQ(unpacked(packed.view()), (std::vector<uint64_t>{0, lit, lit, mixed, lit, 0, 0, 0, lit, lit}));
}

// A free tile takes the class of the last one before it, also where a part of a plane is read alone.
TEST(PackedMask, PartsOfAPlaneReadAsTheWholeDoes) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 200; ++i) {
    const Frame frame = random_frame(random);
    if (frame.grid.planes == 0) continue;
    const PackedMask packed(frame.mask(), frame.valid_bits);
    const std::vector<uint64_t> whole = unpacked(packed.view());
    const size_t tiles = frame.grid.tile_count();
    const size_t plane = random() % frame.grid.planes * tiles;
    const size_t first = plane + random() % tiles, end = first + random() % (plane + tiles - first + 1);
    size_t before = 0, mixed = 0;
    for (size_t word = 0; word < end; ++word) {
      const bool is_mixed = packed.view().class_of(word) == PackedClass::mixed;
      before += is_mixed && word < first;
      mixed += is_mixed;
    }
    std::vector<uint64_t> part;
    const size_t next = for_words_between(
        packed.view(), first, end, before,
        [&](size_t, uint32_t count, bool lit) { part.insert(part.end(), count, lit ? ~uint64_t{0} : 0); },
        [&](size_t, uint64_t word) { part.push_back(word); });
    EXPECT_EQ(next, mixed);
    EXPECT_TRUE(std::equal(part.begin(), part.end(), whole.begin() + static_cast<std::ptrdiff_t>(first),
                           whole.begin() + static_cast<std::ptrdiff_t>(end)));
  }
}

}  // namespace
}  // namespace gnomon::test
