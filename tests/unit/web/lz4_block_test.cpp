// The decoder of LZ4 blocks for browsers beside the library: it takes what the library takes, and nothing else.
#include "web/wasm/lz4_block.h"

#include <gtest/gtest.h>
#include <lz4.h>

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

namespace gnomon::web {
namespace {

using Bytes = std::vector<uint8_t>;

// The library's, with exactly as much memory as it is told of.
std::optional<Bytes> by_library(const Bytes& block, size_t room) {
  Bytes out(std::max<size_t>(room, 1));
  const int size =
      LZ4_decompress_safe(reinterpret_cast<const char*>(block.data()), reinterpret_cast<char*>(out.data()),
                          static_cast<int>(block.size()), static_cast<int>(room));
  if (size < 0) return std::nullopt;
  out.resize(static_cast<size_t>(size));
  return out;
}

std::optional<Bytes> by_us(const Bytes& block, size_t room) {
  Bytes out(room);
  const auto size = unpack_lz4_block(block, out);
  if (!size) return std::nullopt;
  out.resize(*size);
  return out;
}

// Bytes of few kinds, in runs, as class planes and rows are.
Bytes random_bytes(std::mt19937& random) {
  Bytes bytes;
  const size_t size = random() % 4 == 0 ? random() % 20 : random() % 3000;
  const unsigned kinds = 1u << random() % 9;
  while (bytes.size() < size) bytes.insert(bytes.end(), 1 + random() % 40, static_cast<uint8_t>(random() % kinds));
  bytes.resize(size);
  return bytes;
}

Bytes packed(const Bytes& bytes) {
  Bytes block(static_cast<size_t>(LZ4_compressBound(static_cast<int>(bytes.size()))));
  const int size =
      LZ4_compress_default(reinterpret_cast<const char*>(bytes.data()), reinterpret_cast<char*>(block.data()),
                           static_cast<int>(bytes.size()), static_cast<int>(block.size()));
  block.resize(static_cast<size_t>(size));
  return block;
}

TEST(Lz4Block, UnpacksWhatTheLibraryHasPacked) {
  std::mt19937 random(1);
  for (int i = 0; i < 3000; ++i) {
    const Bytes bytes = random_bytes(random);
    const Bytes block = packed(bytes);
    ASSERT_EQ(by_us(block, bytes.size()), bytes) << i;
    ASSERT_EQ(by_us(block, bytes.size() + random() % 70'000), bytes) << i;
  }
}

TEST(Lz4Block, TakesOfDamagedBlocksWhatTheLibraryTakes) {
  std::mt19937 random(2);
  size_t taken = 0, refused = 0;
  for (int i = 0; i < 200'000; ++i) {
    const Bytes bytes = random_bytes(random);
    Bytes block = packed(bytes);
    for (uint32_t changes = random() % 4; changes > 0 && !block.empty(); --changes) {
      const size_t at = random() % block.size();
      switch (random() % 4) {
        case 0: block.resize(at); break;
        case 1: block[at] = static_cast<uint8_t>(random() % 2 ? 0xff : 0xf0); break;
        case 2: block.insert(block.begin() + static_cast<ptrdiff_t>(at), static_cast<uint8_t>(random())); break;
        default: block[at] ^= static_cast<uint8_t>(1u << random() % 8);
      }
    }
    // Where the end is near, the last bytes' rules hold.
    const size_t room =
        random() % 2 ? 65'536 : 1 + bytes.size() + random() % 40 - std::min<size_t>(bytes.size(), 20);
    const auto expected = by_library(block, room), got = by_us(block, room);
    ASSERT_EQ(got, expected) << i << ", room " << room << ", block of " << block.size();
    ++(expected ? taken : refused);
  }
  EXPECT_GT(taken, 20'000u);
  EXPECT_GT(refused, 20'000u);
}

TEST(Lz4Block, TakesOfNoiseWhatTheLibraryTakes) {
  std::mt19937 random(3);
  for (int i = 0; i < 300'000; ++i) {
    Bytes block(random() % 40);
    for (uint8_t& byte : block) byte = static_cast<uint8_t>(random() % 3 == 0 ? random() : random() % 3);
    const size_t room = 1 + random() % 120;
    ASSERT_EQ(by_us(block, room), by_library(block, room)) << i << ", room " << room;
  }
}

}  // namespace
}  // namespace gnomon::web
