// What frames of several queues pay of the device.
#include "gpu/frame/overlap.h"

#include <gtest/gtest.h>

namespace gnomon::test {
namespace {

using gpu::Overlap;

constexpr uint64_t kMs = 1'000'000;
constexpr uint64_t kFrames = 300;  // until the sums know nothing of the first ones

TEST(OverlapTest, FramesOneAfterTheOtherPayWhatTheyTook) {
  Overlap overlap;
  for (uint64_t i = 0; i < kFrames; ++i)
    EXPECT_EQ(overlap.device_ns(10 * i * kMs, (10 * i + 3 + i % 5) * kMs), (3 + i % 5) * kMs);
}

TEST(OverlapTest, TwoQueuesPayTogetherForTheTimeThatPassed) {
  Overlap overlap;
  double paid = 0;
  for (uint64_t i = 0; i < 2 * kFrames; ++i) {  // each takes 2 ms, and one begins every millisecond
    const uint64_t ns = overlap.device_ns(i * kMs, (i + 2) * kMs);
    if (i >= kFrames) paid += static_cast<double>(ns);
  }
  EXPECT_NEAR(paid / static_cast<double>(kFrames * kMs), 1, 0.02);
}

TEST(OverlapTest, ALongFrameBesideShortOnesPaysInProportion) {
  Overlap overlap;
  double longs = 0, shorts = 0;
  for (uint64_t i = 0; i < kFrames; ++i) {  // 10 ms on one queue, 10 frames of 1 ms on the other
    const uint64_t begin = 10 * i * kMs;
    for (uint64_t k = 0; k < 10; ++k) {
      const auto ns = static_cast<double>(overlap.device_ns(begin + k * kMs, begin + (k + 1) * kMs));
      if (i >= kFrames / 2) shorts += ns;
    }
    const auto ns = static_cast<double>(overlap.device_ns(begin, begin + 10 * kMs));
    if (i >= kFrames / 2) longs += ns;
  }
  EXPECT_NEAR(longs / shorts, 1, 0.25) << "they ran equally long";
  EXPECT_NEAR((longs + shorts) / static_cast<double>(kFrames / 2 * 10 * kMs), 1, 0.25);
}

TEST(OverlapTest, NobodyPaysMoreThanItTook) {
  Overlap overlap;
  for (uint64_t i = 0; i < kFrames; ++i) {
    const uint64_t begin = (i * 7919) % 50 * kMs + i * kMs, length = (1 + i % 9) * kMs;
    EXPECT_LE(overlap.device_ns(begin, begin + length), length);
  }
}

}  // namespace
}  // namespace gnomon::test
