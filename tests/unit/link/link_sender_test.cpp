// What a session's link sends, when, and what it retransmits.
#include <gtest/gtest.h>

#include <deque>
#include <set>

#include "daemon/link/link_sender.h"
#include "tests/unit/link/made_frame.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

constexpr TimePoint kStart{10s};

protocol::Feedback all_arrived(uint64_t first, uint64_t last, uint64_t time_us) {
  protocol::Feedback said;
  said.first = first;
  said.count = static_cast<uint16_t>(last - first + 1);
  said.time_us = time_us;
  for (uint64_t i = 0; i < said.count; ++i) said.ages[static_cast<size_t>(i)] = 1;
  return said;
}

struct Probed {
  uint64_t sent = 0;
  TimePoint now;
};

// Sends frames of one small slice and the probes between them, which all arrive, until datagrams may be that long.
Probed probe_up_to(LinkSender& link, size_t bytes) {
  Probed path{0, kStart};
  for (uint32_t frame = 1000; link.datagram_bytes() < bytes && frame < 1100; ++frame) {
    link.add(frame_of(frame, 1), TimePoint::max(), path.now);
    for (const TimePoint until = path.now + 20ms; path.now < until; path.now += 1ms) {
      while (const auto out = link.next(path.now)) {
        link.sent(++path.sent, out->body.size() + protocol::kHeaderBytes + protocol::kTagBytes, path.now);
        const auto now_us = static_cast<uint64_t>(to_microseconds(path.now.time_since_epoch()));
        EXPECT_EQ(link.on_feedback(all_arrived(path.sent, path.sent, now_us), path.now + 1ms),
                  FeedbackVerdict::taken);
      }
    }
  }
  return path;
}

// A scene in plain light has frames of some hundred bytes, which are spread at a pace at which a probe takes long.
TEST(LinkSender, AProbeHoldsUpNoSmallFrames) {
  LinkSender link(protocol::kFeatureFeedback);
  TimePoint now = kStart;
  Nanoseconds longest{};
  uint64_t sent = 0, probes = 0;
  std::deque<TimePoint> waiting;  // when the frames were added that have not gone
  for (uint32_t frame = 1; frame <= 100; ++frame) {
    const TimePoint added = now;
    link.add(frame_of(frame, 1), TimePoint::max(), now);
    waiting.push_back(added);
    for (; now < added + 16ms; now += 1ms) {
      while (const auto out = link.next(now)) {
        if (out->kind == protocol::DatagramKind::probe) {
          ++probes;
        } else {
          longest = std::max(longest, now - waiting.front());
          waiting.pop_front();
        }
        link.sent(++sent, out->body.size() + protocol::kHeaderBytes + protocol::kTagBytes, now);
        const auto now_us = static_cast<uint64_t>(to_microseconds(now.time_since_epoch()));
        EXPECT_EQ(link.on_feedback(all_arrived(sent, sent, now_us), now + 1ms), FeedbackVerdict::taken);
      }
    }
  }
  EXPECT_GE(probes, 5u);
  EXPECT_LE(longest, 50ms) << "the longest probe at the rate of a link that has just begun";
}

TEST(LinkSender, WithoutFeedbackEverythingGoesAtOnce) {
  LinkSender link(0);
  link.add(frame_of(1, 50), TimePoint::max(), kStart);
  uint64_t sent = 0;
  while (link.next(kStart)) link.sent(++sent, 200, kStart);
  EXPECT_EQ(sent, 50u);
  EXPECT_EQ(link.wake_at(kStart), TimePoint::max());
  EXPECT_TRUE(link.may_request(kStart));
}

TEST(LinkSender, WhatQuicFindsLostIsSentAgainWhileItIsOfUse) {
  LinkSender link(protocol::kFeatureWebTransport);
  EXPECT_LE(link.slice_body_bytes(), LinkSender::kMostWebTransportBody);
  link.add(frame_of(1, 3), TimePoint::max(), kStart);
  std::vector<std::vector<uint8_t>> bodies;
  uint64_t sent = 0;
  while (const auto out = link.next(kStart)) {
    bodies.emplace_back(out->body.begin(), out->body.end());
    link.sent(++sent, 200, kStart);
  }
  ASSERT_EQ(sent, 3u);
  link.on_outcome(1, true, kStart + 20ms);
  link.on_outcome(2, false, kStart + 20ms);
  link.on_outcome(2, false, kStart + 21ms);   // once is enough
  link.on_outcome(77, false, kStart + 21ms);  // none was sent
  const auto again = link.next(kStart + 21ms);
  ASSERT_TRUE(again);
  EXPECT_EQ(std::vector<uint8_t>(again->body.begin(), again->body.end()), bodies[1]);
  link.sent(++sent, 200, kStart + 21ms);
  EXPECT_FALSE(link.next(kStart + 21ms));
  link.on_outcome(3, false, kStart + 2s);
  EXPECT_FALSE(link.next(kStart + 2s)) << "nobody waits for it any more";
  EXPECT_EQ(link.counters().retransmitted, 1u);
  EXPECT_EQ(link.counters().arrived, 1u);
}

TEST(LinkSender, WhatWaitsForRoomIsBoundedByTheFramesThatAreKept) {
  LinkSender link(0);
  for (uint32_t frame = 1; frame <= 100; ++frame) {
    link.add(frame_of(frame, 50), TimePoint::max(), kStart);
    link.next(kStart);  // is not sent
    EXPECT_FALSE(link.may_request(kStart));
  }
  uint64_t sent = 0;
  std::set<uint32_t> frames;
  while (const auto out = link.next(kStart)) {
    frames.insert(protocol::decode_frame_slice(out->body)->header.frame.value);
    link.sent(++sent, 200, kStart);
  }
  EXPECT_EQ(frames, (std::set<uint32_t>{97, 98, 99, 100}));
  EXPECT_EQ(link.counters().too_late, 96u * 50u);
  EXPECT_TRUE(link.may_request(kStart));
}

TEST(LinkSender, ADatagramThatItDidNotOfferIsOnlyCounted) {
  LinkSender link(0);
  link.add(frame_of(1, 3), TimePoint::max(), kStart);
  ASSERT_TRUE(link.next(kStart));
  link.sent(1, 168, kStart);
  link.sent(2, 168, kStart);
  EXPECT_EQ(link.counters().sent, 2u);
  for (uint64_t slice = 1; slice < 3; ++slice) {
    const auto out = link.next(kStart);
    ASSERT_TRUE(out);
    EXPECT_EQ(protocol::decode_frame_slice(out->body)->header.slice, slice);
    link.sent(2 + slice, 168, kStart);
  }
}

TEST(LinkSender, OfWhatAClientCountedBeforeItWasResumedNothingCounts) {
  for (const bool resumed : {false, true}) {
    LinkSender link(protocol::kFeatureFeedback, resumed ? std::optional<uint64_t>(5) : std::nullopt);
    protocol::Feedback said;
    said.recovered = 7;
    said.incomplete = 9;
    EXPECT_EQ(link.on_feedback(said, kStart), FeedbackVerdict::taken);
    EXPECT_EQ(link.counters().recovered, resumed ? 0u : 7u);
    EXPECT_EQ(link.counters().incomplete, resumed ? 0u : 9u);
    said.recovered = 8;
    said.incomplete = 11;
    EXPECT_EQ(link.on_feedback(said, kStart + 10ms), FeedbackVerdict::taken);
    EXPECT_EQ(link.counters().recovered, resumed ? 1u : 8u);
    EXPECT_EQ(link.counters().incomplete, resumed ? 2u : 11u);
  }
}

TEST(LinkCounters, ADifferenceIsOneOfEachCount) {
  const LinkCounters before{1, 2, 3, 4, 5, 6, 7, 8}, after{2, 4, 6, 8, 10, 12, 14, 16};
  const LinkCounters since = after - before;
  EXPECT_EQ(since.sent, 1u);
  EXPECT_EQ(since.arrived, 2u);
  EXPECT_EQ(since.lost, 3u);
  EXPECT_EQ(since.retransmitted, 4u);
  EXPECT_EQ(since.parity, 5u);
  EXPECT_EQ(since.recovered, 6u);
  EXPECT_EQ(since.incomplete, 7u);
  EXPECT_EQ(since.too_late, 8u);
}

TEST(LinkSender, PacesAFrame) {
  LinkSender link(protocol::kFeatureFeedback);
  link.add(frame_of(1, 50, 1000), TimePoint::max(), kStart);
  uint64_t sent = 0;
  while (link.next(kStart)) link.sent(++sent, 1068, kStart);
  EXPECT_LT(sent, 10u);
  EXPECT_GT(link.wake_at(kStart), kStart);
  for (TimePoint now = kStart; sent < 50; now = link.wake_at(now)) {
    ASSERT_LT(now, kStart + 1s);
    while (link.next(now)) link.sent(++sent, 1068, now);
  }
}

// The path no longer carries long datagrams, and the client asks for nothing new before it has its answer.
TEST(LinkSender, AnAnswerThatAllCameToNothingMayBeMadeAnewShorter) {
  LinkSender link(protocol::kFeatureFeedback);
  const Probed path = probe_up_to(link, 1472);
  ASSERT_EQ(link.datagram_bytes(), 1472u);
  uint64_t sent = path.sent;
  link.add(frame_of(1, 4, 1300), TimePoint::max(), path.now);
  TimePoint now = path.now;
  for (; now < path.now + 150ms; now += 1ms) {
    EXPECT_FALSE(link.take_lost(FrameId{1}, now)) << "it may still come";
    while (link.next(now)) link.sent(++sent, 1368, now);
  }
  now = path.now + 2s;
  EXPECT_FALSE(link.take_lost(FrameId{2}, now)) << "never answered";
  ASSERT_TRUE(link.take_lost(FrameId{1}, now));
  EXPECT_FALSE(link.take_lost(FrameId{1}, now)) << "once";
  EXPECT_TRUE(link.may_request(now));
  EXPECT_EQ(link.datagram_bytes(), protocol::kMaxDatagramBytes);

  // Acknowledgements of the first answer's slices do not apply to the second's.
  link.add(frame_of(1, 1), TimePoint::max(), now);
  EXPECT_EQ(link.on_feedback(all_arrived(path.sent + 1, sent, 1000), now + 1ms), FeedbackVerdict::taken);
  EXPECT_FALSE(link.take_lost(FrameId{2}, now + 1ms));
  const auto out = link.next(now + 1ms);
  ASSERT_TRUE(out);
  const auto slice = protocol::decode_frame_slice(out->body);
  ASSERT_TRUE(slice);
  EXPECT_EQ(slice->header.slice_count, 1u);
}

// With a round trip of 90 ms and a tenth of the datagrams lost, frames have parity.
TEST(LinkSender, AnAnswerWithParityIsNotMadeAnew) {
  LinkSender link(protocol::kFeatureFeedback | protocol::kFeatureParity);
  uint64_t sent = 0;
  TimePoint now = kStart;
  const auto fly = [&](uint32_t frame) {
    link.add(frame_of(frame, 20), now + 100ms, now);
    const uint64_t first = sent + 1;
    for (const TimePoint until = now + 16ms; now < until; now += 1ms) {
      while (link.next(now)) link.sent(++sent, 168, now);
    }
    return first;
  };
  for (uint32_t frame = 1; frame < 200 && link.counters().parity == 0; ++frame) {
    const uint64_t first = fly(frame);
    if (sent < first) continue;
    auto said = all_arrived(first, sent, static_cast<uint64_t>(to_microseconds(now.time_since_epoch())));
    for (size_t i = 0; i < said.count; i += 10) said.ages[i] = 0;
    EXPECT_EQ(link.on_feedback(said, now + 90ms), FeedbackVerdict::taken);
  }
  ASSERT_GT(link.counters().parity, 0u);
  fly(1000);
  EXPECT_FALSE(link.take_lost(FrameId{1000}, now + 10s));
}

TEST(LinkSender, AnAnswerOfWhichSomethingCameIsNotMadeAnew) {
  LinkSender link(protocol::kFeatureFeedback);
  link.add(frame_of(1, 4), TimePoint::max(), kStart);
  uint64_t sent = 0;
  TimePoint now = kStart;
  for (; sent < 4; now += 1ms) {
    while (link.next(now)) link.sent(++sent, 168, now);
  }
  EXPECT_EQ(link.on_feedback(all_arrived(1, 1, 1000), now), FeedbackVerdict::taken);
  EXPECT_FALSE(link.take_lost(FrameId{1}, now + 10s));
}

TEST(LinkSender, AReportOfWhatWasNeverSentHasNoEffect) {
  LinkSender link(protocol::kFeatureFeedback);
  link.add(frame_of(1, 4), TimePoint::max(), kStart);
  ASSERT_TRUE(link.next(kStart));
  link.sent(1, 168, kStart);
  link.omitted(2);
  ASSERT_TRUE(link.next(kStart));
  link.sent(3, 168, kStart);
  link.sent(4, 1200, kStart);  // a Pong
  EXPECT_EQ(link.on_feedback(all_arrived(1, 3, 1000), kStart + 5ms), FeedbackVerdict::invented)
      << "number 2 was left out";
  EXPECT_EQ(link.on_feedback(all_arrived(3, 5, 1000), kStart + 5ms), FeedbackVerdict::invented)
      << "number 5 is still to come";
  EXPECT_EQ(link.counters().arrived, 0u);
  EXPECT_EQ(link.on_feedback(all_arrived(3, 4, 1000), kStart + 5ms), FeedbackVerdict::taken);
  EXPECT_EQ(link.counters().arrived, 1u) << "a Pong is of no frame";
}

// The cost of a report stays the same however long the client's clock has run backwards.
TEST(LinkSender, AClientsClockNeitherCostsNorKeepsAnything) {
  for (const int64_t step : std::initializer_list<int64_t>{10'000, 0, -10'000, int64_t{1} << 61}) {
    LinkSender link(protocol::kFeatureFeedback);
    uint64_t sent = 0, clock = uint64_t{1} << 62;
    TimePoint now = kStart;
    for (uint32_t frame = 1; frame <= 2000; ++frame, now += 10ms) {
      link.add(frame_of(frame, 20), TimePoint::max(), now);
      const uint64_t first = sent + 1;
      while (link.next(now)) link.sent(++sent, 168, now);
      clock += static_cast<uint64_t>(step);
      if (sent >= first) {
        EXPECT_EQ(link.on_feedback(all_arrived(first, sent, clock), now + 5ms), FeedbackVerdict::taken);
      }
      EXPECT_LT(link.queue_delay(), 3h);
      EXPECT_GT(link.queue_delay(), -3h);
    }
    EXPECT_GT(link.counters().arrived, 1000u) << step;
  }
}

// Fills the link with frames whose datagrams arrive 20 ms later, and returns the number of the last datagram.
uint64_t fly_until_known(LinkSender& link, TimePoint& now) {
  uint64_t sent = 0;
  for (uint32_t frame = 1; frame <= 200; ++frame) {
    link.add(frame_of(frame, 40, 1000), TimePoint::max(), now);
    link.may_request(now);
    const uint64_t first = sent + 1;
    for (const TimePoint until = now + 16ms; now < until; now += 1ms) {
      while (const auto out = link.next(now)) link.sent(++sent, out->body.size() + 36, now);
      link.may_request(now);
    }
    if (sent < first) continue;
    const auto time_us = static_cast<uint64_t>(to_microseconds(now.time_since_epoch()));
    EXPECT_EQ(link.on_feedback(all_arrived(first, sent, time_us), now + 4ms), FeedbackVerdict::taken);
  }
  return sent;
}

// RFC 9000, 9.4: rate and round trip begin anew, and datagrams to the former path count for nothing.
TEST(LinkSender, AnotherPathBeginsAnew) {
  LinkSender link(protocol::kFeatureFeedback);
  TimePoint now = kStart;
  uint64_t sent = fly_until_known(link, now);
  ASSERT_GT(link.rate(), 2 * RateController::kFirstRate);
  ASSERT_GT(link.rtt(), 0ms);
  ASSERT_GT(link.datagram_bytes(), protocol::kMaxDatagramBytes);
  link.add(frame_of(1000, 4), TimePoint::max(), now);
  const uint64_t before = sent + 1;
  for (int i = 0; i < 10; ++i, now += 1ms) {
    while (link.next(now)) link.sent(++sent, 168, now);
  }
  ASSERT_GE(sent, before);
  link.begin_path(now);
  EXPECT_EQ(link.rate(), RateController::kFirstRate);
  EXPECT_EQ(link.rtt(), 0ms);
  EXPECT_EQ(link.datagram_bytes(), protocol::kMaxDatagramBytes);
  const uint64_t arrived = link.counters().arrived;
  const auto time_us = static_cast<uint64_t>(to_microseconds(now.time_since_epoch()));
  EXPECT_EQ(link.on_feedback(all_arrived(before, sent, time_us), now + 900ms), FeedbackVerdict::taken);
  EXPECT_GT(link.counters().arrived, arrived) << "they have arrived all the same";
  EXPECT_EQ(link.rtt(), 0ms) << "and do not measure this path";

  // The new path is 80 ms longer, which is no queue.
  now += 1s;
  link.add(frame_of(1001, 8), TimePoint::max(), now);
  const uint64_t after = sent + 1;
  for (int i = 0; i < 20; ++i, now += 1ms) {
    while (link.next(now)) link.sent(++sent, 168, now);
  }
  ASSERT_GE(sent, after + 4);
  const auto longer_us = static_cast<uint64_t>(to_microseconds((now + 80ms).time_since_epoch()));
  EXPECT_EQ(link.on_feedback(all_arrived(after, sent, longer_us), now + 100ms), FeedbackVerdict::taken);
  EXPECT_GT(link.rtt(), 0ms);
  EXPECT_LT(link.queue_delay(), 20ms);
}

TEST(LinkSender, AFloodOfReportsIsNotTaken) {
  LinkSender link(protocol::kFeatureFeedback);
  int taken = 0;
  for (TimePoint now = kStart; now < kStart + 1s; now += 50us)
    taken += link.on_feedback({}, now) == FeedbackVerdict::taken;
  EXPECT_NEAR(taken, FeedbackAllowance::kPerSecond + FeedbackAllowance::kMost, 2);
}

TEST(LinkSender, NothingGoesAfterItsDeadline) {
  LinkSender link(protocol::kFeatureFeedback);
  link.add(frame_of(1, 50, 1000), kStart + 20ms, kStart);
  uint64_t sent = 0;
  while (link.next(kStart)) link.sent(++sent, 1068, kStart);
  EXPECT_FALSE(link.next(kStart + 20ms));
  EXPECT_EQ(link.counters().too_late, 50 - sent);
}

// Sends a complete frame, loses slice 2, and delivers the Feedback on it at `heard`. Returns the retransmissions.
uint64_t sent_again(TimePoint deadline, TimePoint heard) {
  LinkSender link(protocol::kFeatureFeedback);
  link.add(frame_of(1, 12), deadline, kStart);
  uint64_t sent = 0;
  TimePoint now = kStart;
  for (; sent < 12; now += 100us) {
    while (link.next(now)) link.sent(++sent, 168, now);
  }
  protocol::Feedback said;
  said.first = 1;
  said.count = 12;
  said.time_us = 1000000;
  for (size_t i = 0; i < 12; ++i) said.ages[i] = i == 2 ? 0 : 1;
  EXPECT_EQ(link.on_feedback(said, heard), FeedbackVerdict::taken);
  said.time_us += 30000;
  EXPECT_EQ(link.on_feedback(said, heard + 30ms), FeedbackVerdict::taken);
  while (link.next(heard + 31ms)) link.sent(++sent, 168, heard + 31ms);
  EXPECT_EQ(link.take_extra_bytes(), 168 * (sent - 12)) << "somebody pays for what goes again, and for probes";
  EXPECT_EQ(link.take_extra_bytes(), 0u);
  return link.counters().retransmitted;
}

TEST(LinkSender, ALostSliceGoesAgainIfItCanStillBeOfUse) {
  EXPECT_EQ(sent_again(TimePoint::max(), kStart + 25ms), 1u);
  EXPECT_EQ(sent_again(kStart + 150ms, kStart + 25ms), 1u);
  EXPECT_EQ(sent_again(kStart + 40ms, kStart + 25ms), 0u);
}

}  // namespace
}  // namespace gnomon::daemon
