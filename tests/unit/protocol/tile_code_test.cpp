#include "protocol/tile_code.h"

#include <gtest/gtest.h>

#include <array>
#include <random>

namespace gnomon::protocol {
namespace {

struct Coded {
  TileClass tile_class;
  std::vector<uint8_t> bytes;
};

Coded code(uint64_t word) {
  std::array<uint8_t, kMaxTileBytes> bytes{};
  uint8_t* end = bytes.data();
  const TileClass tile_class = encode_tile(word, end);
  return {tile_class, {bytes.data(), end}};
}

void expect_comes_back(uint64_t word) {
  const Coded coded = code(word);
  std::span<const uint8_t> bytes = coded.bytes;
  uint64_t back = 0;
  ASSERT_TRUE(decode_tile(coded.tile_class, bytes, back));
  EXPECT_TRUE(bytes.empty());
  EXPECT_EQ(back, word) << std::hex << word;
}

bool is_uniform(uint64_t word) { return word == 0 || word == ~uint64_t{0}; }

TEST(TileCode, EveryTileComesBackAsItWas) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 100000; ++i) {
    uint64_t word = random();
    for (uint64_t sparse = random() % 4; sparse > 0; --sparse) word &= random();
    if (random() % 2) word = ~word;
    if (random() % 4 == 0) word &= uint64_t{0xff} << (random() % 8 * 8);     // a row
    if (random() % 4 == 0) word &= 0x0101010101010101ull << (random() % 8);  // a column
    if (!is_uniform(word)) expect_comes_back(word);
  }
  for (int bit = 0; bit < 64; ++bit) expect_comes_back(uint64_t{1} << bit);
}

TEST(TileCode, EveryLineIsCodedAsALine) {
  for (unsigned flags = 0; flags < 0x40; ++flags) {
    for (unsigned steps = 0; steps < 0x80; ++steps) {
      const std::array<uint8_t, 2> bytes = {static_cast<uint8_t>(flags), static_cast<uint8_t>(steps)};
      std::span<const uint8_t> rest = bytes;
      uint64_t word = 0;
      ASSERT_TRUE(decode_tile(TileClass::line, rest, word));
      EXPECT_TRUE(rest.empty());
      if (is_uniform(word)) continue;
      const Coded coded = code(word);
      EXPECT_EQ(coded.tile_class, TileClass::line) << std::hex << word;
      EXPECT_EQ(coded.bytes.size(), 2u);
      expect_comes_back(word);
    }
  }
}

// Why the class exists: whatever straight border crosses a tile, two bytes hold it.
TEST(TileCode, EveryHalfPlaneIsALine) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> unit(-1, 1);
  int borders = 0;
  for (int i = 0; i < 50000; ++i) {
    const double a = unit(random), b = unit(random), c = 6 * unit(random);
    uint64_t word = 0;
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 8; ++x) word |= uint64_t{a * (x - 3.5) + b * (y - 3.5) > c} << (y * 8 + x);
    }
    if (is_uniform(word)) continue;
    ++borders;
    EXPECT_EQ(code(word).tile_class, TileClass::line) << std::hex << word;
    expect_comes_back(word);
  }
  EXPECT_GT(borders, 10000);
}

TEST(TileCode, RowsTakeAByteForEachThatDiffersFromTheOneAbove) {
  EXPECT_EQ(code(0x0000183c3c180000).bytes, (std::vector<uint8_t>{0x6c, 0x18, 0x3c, 0x18, 0x00}));
  EXPECT_EQ(code(0x1818181818181818).bytes, (std::vector<uint8_t>{0x01, 0x18}));
  EXPECT_EQ(code(0x55aa55aa55aa55aa).bytes.size(), kMaxTileBytes);
}

TEST(TileCode, MissingBytesAreAnError) {
  for (const uint64_t word : {0x0000183c3c180000ull, 0x00000103070f1f3full}) {
    const Coded coded = code(word);
    for (size_t size = 0; size < coded.bytes.size(); ++size) {
      std::span<const uint8_t> bytes = std::span(coded.bytes).first(size);
      uint64_t back = 0;
      EXPECT_FALSE(decode_tile(coded.tile_class, bytes, back));
    }
  }
}

}  // namespace
}  // namespace gnomon::protocol
