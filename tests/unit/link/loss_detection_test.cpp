#include "daemon/link/loss_detection.h"

#include <gtest/gtest.h>

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

constexpr TimePoint kStart{10s};
constexpr Nanoseconds kOneWay = 20ms;
constexpr Nanoseconds kOtherClock = 5h;  // the client's clock is ahead by this

// Sends `count` datagrams of 1,000 bytes, one each millisecond.
LossDetection log_of(uint64_t count) {
  LossDetection log;
  for (uint64_t s = 1; s <= count; ++s) {
    log.sent(s, {kStart + s * 1ms, 1000, Cargo::slice, 1, static_cast<uint16_t>(s)});
  }
  return log;
}

// The client's Feedback at `now` if every datagram that is not in `lost` arrived kOneWay after it was sent.
protocol::Feedback feedback(uint64_t first, uint64_t last, TimePoint now, std::vector<uint64_t> lost = {}) {
  protocol::Feedback said;
  const Nanoseconds clock = now.time_since_epoch() + kOtherClock;
  said.time_us = static_cast<uint64_t>(to_microseconds(clock));
  said.first = first;
  for (uint64_t s = first; s <= last; ++s) {
    const Nanoseconds age = now - (kStart + s * 1ms + kOneWay);
    const bool arrived = std::find(lost.begin(), lost.end(), s) == lost.end();
    said.ages[said.count++] = arrived ? static_cast<uint16_t>(1 + to_microseconds(age) / protocol::kAgeUnitUs) : 0;
  }
  return said;
}

std::vector<uint16_t> numbers(const std::vector<SentDatagram>& datagrams) {
  std::vector<uint16_t> all;
  for (const auto& datagram : datagrams) all.push_back(datagram.number);
  return all;
}

TEST(LossDetection, ArrivalsAreToldOnceWithTheirDelayAndTheRoundTrip) {
  LossDetection log = log_of(4);
  const TimePoint said = kStart + 24ms, heard = said + 15ms;
  const PathUpdate update = log.take(feedback(1, 4, said), heard);
  ASSERT_EQ(update.arrived.size(), 4u);
  for (const Arrival& arrival : update.arrived) {
    EXPECT_NEAR(to_milliseconds(arrival.one_way - update.arrived[0].one_way), 0, 0.05) << "all took the same time";
  }
  EXPECT_NEAR(to_milliseconds(update.rtt), 35, 0.05) << "without the time that the client waited";
  EXPECT_TRUE(log.take(feedback(1, 4, said), heard).arrived.empty());
}

TEST(LossDetection, WhatOthersOvertookIsLostAfterARoundTrip) {
  LossDetection log = log_of(40);
  EXPECT_TRUE(log.take(feedback(1, 12, kStart + 32ms, {9}), kStart + 52ms).lost.empty()) << "it may be late";
  EXPECT_EQ(numbers(log.take(feedback(1, 30, kStart + 50ms, {9}), kStart + 70ms).lost), std::vector<uint16_t>{9});
  EXPECT_TRUE(log.take(feedback(1, 35, kStart + 60ms, {9}), kStart + 80ms).lost.empty()) << "once";
}

TEST(LossDetection, TheNewestIsNotLostYet) {
  LossDetection log = log_of(10);
  EXPECT_TRUE(log.take(feedback(1, 8, kStart + 29ms, {7}), kStart + 300ms).lost.empty())
      << "only one was sent after it, and at once";
}

TEST(LossDetection, OneThatArrivesAfterAllIsToldToo) {
  LossDetection log = log_of(40);
  ASSERT_EQ(log.take(feedback(1, 30, kStart + 60ms, {6}), kStart + 80ms).lost.size(), 1u);
  const auto late = log.take(feedback(1, 30, kStart + 90ms), kStart + 100ms);
  ASSERT_EQ(late.arrived.size(), 1u);
  EXPECT_EQ(late.arrived[0].sent.number, 6u);
}

TEST(LossDetection, ATailIsTriedAgainOneByOne) {
  LossDetection log = log_of(10);
  log.take(feedback(1, 5, kStart + 26ms), kStart + 46ms);
  EXPECT_FALSE(log.take_tail(kStart + 20ms));
  ASSERT_LT(log.tail_due(), kStart + 1s);
  const auto tail = log.take_tail(log.tail_due());
  ASSERT_TRUE(tail);
  EXPECT_EQ(tail->number, 10u);
  EXPECT_GT(log.tail_due(), kStart + 60ms) << "and then patience again";
}

// RFC 6298, 2.2: after the first measurement R the variation is R / 2, and the timeout includes four variations.
TEST(LossDetection, TheFirstTailWaitsThreeRoundTripsAndAReport) {
  LossDetection log = log_of(10);
  const PathUpdate news = log.take(feedback(1, 5, kStart + 26ms), kStart + 46ms);
  EXPECT_NEAR(to_milliseconds(log.tail_due() - (kStart + 10ms)), 3 * to_milliseconds(news.rtt) + 15, 0.1);
}

TEST(LossDetection, SilenceCountsFromTheLastArrivalWhileSomethingIsUnderWay) {
  EXPECT_EQ(LossDetection().silence(kStart), 0ms);
  LossDetection log = log_of(10);
  EXPECT_EQ(log.silence(kStart + 101ms), 100ms) << "since the first was sent";
  log.take(feedback(1, 5, kStart + 26ms), kStart + 46ms);
  EXPECT_EQ(log.silence(kStart + 146ms), 100ms);
  log.take(feedback(1, 10, kStart + 31ms), kStart + 51ms);
  EXPECT_EQ(log.silence(kStart + 10s), 0ms);
}

TEST(LossDetection, WhatIsTriedAgainInVainIsSilenceToo) {
  LossDetection log = log_of(10);
  log.take(feedback(1, 5, kStart + 26ms), kStart + 46ms);
  while (log.take_tail(log.tail_due())) {
  }
  EXPECT_EQ(log.silence(kStart + 1046ms), 1s);
  log.take(feedback(1, 8, kStart + 1050ms), kStart + 1050ms);
  EXPECT_EQ(log.silence(kStart + 10s), 0ms) << "two that did not come may have been lost by chance";
}

TEST(LossDetection, NonsenseIsSurvived) {
  LossDetection log = log_of(10);
  protocol::Feedback said;
  said.first = ~uint64_t{0} - 3;
  said.count = protocol::kMaxReported;
  said.ages.fill(1);
  EXPECT_TRUE(log.take(said, kStart + 1s).arrived.empty());
  said.first = 0;
  said.time_us = ~uint64_t{0};
  log.take(said, kStart + 1s);
  EXPECT_GE(log.rtt(), 0ns);
}

TEST(LossDetection, WhatWasNeverSentCannotHaveArrived) {
  LossDetection log = log_of(10);
  protocol::Feedback said;
  said.count = 1;
  said.ages[0] = 1;
  for (const uint64_t number : {uint64_t{0}, uint64_t{11}, ~uint64_t{0}}) {
    said.first = number;
    EXPECT_TRUE(log.is_invented(said)) << number;
  }
  said.first = 10;
  EXPECT_FALSE(log.is_invented(said));
  said.first = 11;
  said.ages[0] = 0;
  EXPECT_FALSE(log.is_invented(said)) << "nobody said that it had come";
  LossDetection resumed(1000);
  said.ages[0] = 1;
  EXPECT_FALSE(resumed.is_invented({.first = 1000, .count = 1, .ages = {1}})) << "of the server before";
  EXPECT_TRUE(resumed.is_invented({.first = 1001, .count = 1, .ages = {1}}));
}

TEST(LossDetection, AnOmittedNumberIsNeverLostAndNeverArrives) {
  LossDetection with, without;
  for (uint64_t s = 1, sequence = 1; s <= 40; ++s, ++sequence) {
    const SentDatagram datagram{kStart + s * 1ms, 1000, Cargo::slice, 1, static_cast<uint16_t>(s)};
    without.sent(s, datagram);
    if (s % 3 == 0) with.omitted(sequence++);
    with.sent(sequence, datagram);
  }
  // A third of the numbers is missing: datagram s has the number s + s / 3.
  protocol::Feedback plain, gaps;
  plain.first = gaps.first = 1;
  plain.time_us = gaps.time_us = 1;
  plain.count = 30;
  gaps.count = 40;
  for (uint64_t s = 1; s <= 30; ++s) {
    plain.ages[s - 1] = gaps.ages[s + s / 3 - 1] = static_cast<uint16_t>(s == 20 ? 0 : 1 + (30 - s) * 1000 / 32);
  }
  EXPECT_FALSE(with.is_invented(gaps));
  const PathUpdate a = with.take(gaps, kStart + 70ms), b = without.take(plain, kStart + 70ms);
  EXPECT_EQ(numbers(a.lost), numbers(b.lost));
  EXPECT_EQ(numbers(a.lost), std::vector<uint16_t>{20});
  EXPECT_EQ(a.arrived.size(), b.arrived.size());
  EXPECT_EQ(a.rtt, b.rtt);
  EXPECT_EQ(with.silence(kStart + 1s), without.silence(kStart + 1s));
  EXPECT_EQ(with.tail_due(), without.tail_due());
  gaps.ages[2] = 1;  // the first number that was left out
  EXPECT_TRUE(with.is_invented(gaps));
}

TEST(LossDetection, NumbersOfOtherDatagramsCountForNothing) {
  LossDetection log;
  log.sent_beside(1);
  EXPECT_EQ(log.tail_due(), TimePoint::max()) << "nothing to wait for";
  for (uint64_t s = 2; s <= 6; ++s)
    log.sent(s, {kStart + s * 1ms, 1000, Cargo::slice, 1, static_cast<uint16_t>(s)});
  log.sent_beside(7);
  protocol::Feedback said{.time_us = 1, .first = 1, .count = 7, .ages = {1, 1, 1, 1, 1, 1, 1}};
  EXPECT_FALSE(log.is_invented(said));
  EXPECT_EQ(log.take(said, kStart + 50ms).arrived.size(), 5u);
  EXPECT_EQ(log.silence(kStart + 10s), 0ms);
  EXPECT_EQ(log.tail_due(), TimePoint::max());
}

TEST(LossDetection, ARoundTripIsNoLongerThanPathsAre) {
  LossDetection log = log_of(1);
  EXPECT_LE(log.take({.first = 1, .count = 1, .ages = {1}}, kStart + 1h).rtt, 10s);
}

TEST(LossDetection, MemoryIsBounded) {
  LossDetection log = log_of(100000);
  const auto update = log.take(feedback(99000, 99400, kStart + 99421ms), kStart + 99430ms);
  EXPECT_EQ(update.arrived.size(), 401u);
  EXPECT_LE(update.lost.size(), 1u << 14);
}

}  // namespace
}  // namespace gnomon::daemon
