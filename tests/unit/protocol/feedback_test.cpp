#include "protocol/feedback.h"

#include <gtest/gtest.h>

#include "tests/unit/protocol/random_messages.h"

namespace gnomon::protocol {
namespace {

Feedback random_feedback(tests::Random& random, uint16_t count) {
  Feedback feedback;
  feedback.time_us = random();
  feedback.first = random();
  feedback.recovered = static_cast<uint32_t>(random());
  feedback.incomplete = static_cast<uint32_t>(random());
  feedback.count = count;
  for (size_t i = 0; i < count; ++i) feedback.ages[i] = static_cast<uint16_t>(random());
  return feedback;
}

TEST(Feedback, ComesBackAsItWasAndCutShortNotAtAll) {
  tests::Random random(1);
  for (const uint16_t count : {0, 1, 3, 511, 512}) {
    const Feedback sent = random_feedback(random, count);
    std::vector<uint8_t> bytes;
    append_feedback(bytes, sent);
    ASSERT_EQ(bytes.size(), 26u + 2u * count);
    const auto got = decode_feedback(bytes);
    ASSERT_TRUE(got);
    EXPECT_EQ(got->time_us, sent.time_us);
    EXPECT_EQ(got->first, sent.first);
    EXPECT_EQ(got->recovered, sent.recovered);
    EXPECT_EQ(got->incomplete, sent.incomplete);
    EXPECT_EQ(got->count, count);
    EXPECT_EQ(got->ages, sent.ages);
    for (size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_FALSE(decode_feedback(std::span(bytes).first(size))) << size;
    }
  }
}

TEST(Feedback, MoreThanItMayReportIsRefused) {
  std::vector<uint8_t> bytes;
  append_feedback(bytes, {});
  bytes[24] = 0x01;
  bytes[25] = 0x02;  // 513
  bytes.resize(4096);
  EXPECT_FALSE(decode_feedback(bytes));
}

}  // namespace
}  // namespace gnomon::protocol
