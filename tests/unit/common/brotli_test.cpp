#include "common/brotli.h"

#include <brotli/decode.h>
#include <gtest/gtest.h>

#include <random>

namespace gnomon {
namespace {

std::vector<std::byte> unpacked(const std::vector<std::byte>& packed, size_t size) {
  std::vector<std::byte> out(size + 1);
  size_t got = out.size();
  EXPECT_EQ(BrotliDecoderDecompress(packed.size(), reinterpret_cast<const uint8_t*>(packed.data()), &got,
                                    reinterpret_cast<uint8_t*>(out.data())),
            BROTLI_DECODER_RESULT_SUCCESS);
  out.resize(got);
  return out;
}

TEST(Brotli, UnpacksToWhatWasPacked) {
  std::mt19937 random(1);
  for (const size_t size : {size_t{0}, size_t{1}, size_t{70'000}}) {
    for (const unsigned distinct : {1u, 3u, 256u}) {
      std::vector<std::byte> bytes(size);
      for (std::byte& b : bytes) b = static_cast<std::byte>(random() % distinct);
      for (const int quality : {0, kBrotliQuality}) {
        const auto packed = brotli(bytes, quality);
        ASSERT_TRUE(packed) << packed.error().message;
        EXPECT_EQ(unpacked(*packed, size), bytes) << size << ", " << distinct << ", " << quality;
      }
    }
  }
}

TEST(Brotli, WhatRepeatsGetsSmall) {
  const auto packed = brotli(std::vector<std::byte>(1 << 20));
  ASSERT_TRUE(packed);
  EXPECT_LT(packed->size(), 100u);
}

}  // namespace
}  // namespace gnomon
