// The small parts of a session's link, one by one.
#include <gtest/gtest.h>

#include <random>

#include "client/net/arrival_report.h"
#include "client/stream/slice_recovery.h"
#include "daemon/link/link_sender.h"
#include "daemon/link/parity_plan.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<uint8_t>;

constexpr TimePoint kStart{10s};

TEST(QueueDelay, IsWhatGoesBeyondTheLeastWhateverTheClocksSay) {
  QueueDelay queue;
  for (int i = 0; i < 10; ++i) queue.add(-1h + 20ms, kStart);
  EXPECT_EQ(queue.now(), 0ms);
  for (int i = 0; i < 4; ++i) queue.add(-1h + 32ms, kStart);
  EXPECT_EQ(queue.now(), 12ms);
  queue.add(-1h + 21ms, kStart);
  EXPECT_EQ(queue.now(), 1ms) << "one that came through tells that there is no queue";
}

TEST(QueueDelay, ForgetsAnOldPathInAMinute) {
  QueueDelay queue;
  for (int i = 0; i < 4; ++i) queue.add(10ms, kStart);
  for (int s = 1; s < 90; ++s) {
    for (int i = 0; i < 4; ++i) queue.add(50ms, kStart + s * 1s);
  }
  EXPECT_EQ(queue.now(), 0ms);
}

TEST(Pacer, KeepsTheRateInSmallBatches) {
  Pacer pacer;
  size_t sent = 0;
  for (TimePoint now = kStart; now < kStart + 1s; now += 700us) {
    size_t batch = 0;
    while (pacer.may_send(now)) {
      pacer.sent(1200, 2.4e6, now);
      sent += 1200;
      ++batch;
    }
    EXPECT_LE(batch, 4u);
  }
  EXPECT_NEAR(static_cast<double>(sent), 2.4e6, 0.01e6);
}

TEST(ParityPlan, MoreLossTakesMoreParityAndFewerSlicesRelativelyMore) {
  EXPECT_LT(parity_count(32, 0.01), parity_count(32, 0.05));
  EXPECT_LT(parity_count(32, 0.05), parity_count(32, 0.2));
  EXPECT_GT(parity_count(4, 0.05) * 8, parity_count(32, 0.05));
  EXPECT_EQ(parity_count(1, 0.3), 1u);
  EXPECT_LE(parity_count(32, 0.9), 16u);
  EXPECT_EQ(parity_groups(32), 1u);
  EXPECT_EQ(parity_groups(33), 2u);
}

// Of many groups with that much parity: the share that cannot be rebuilt.
double failures(size_t slices, size_t parity, double loss) {
  std::mt19937_64 random(1);
  std::bernoulli_distribution lost(loss);
  int failed = 0;
  for (int group = 0; group < 20000; ++group) {
    size_t count = 0;
    for (size_t i = 0; i < slices + parity; ++i) count += lost(random);
    failed += count > parity;
  }
  return failed / 20000.0;
}

TEST(ParityPlan, KeepsItsWordAndWithOneShardLessWouldNot) {
  const std::vector<std::pair<size_t, double>> cases{{32, 0.05}, {32, 0.01}, {16, 0.1}, {8, 0.02}};
  for (const auto& [slices, loss] : cases) {
    const size_t parity = parity_count(slices, loss);
    EXPECT_LE(failures(slices, parity, loss), 1.2 * kGroupFailure) << slices << " slices, " << loss;
    EXPECT_GT(failures(slices, parity - 1, loss), 0.8 * kGroupFailure) << slices << " slices, " << loss;
  }
}

TEST(MtuDiscovery, FindsWhatThePathTakes) {
  MtuDiscovery mtu;
  TimePoint now = kStart;
  for (int i = 0; i < 100; ++i, now += 60ms) {
    const auto size = mtu.probe_due(now);
    if (!size) continue;
    mtu.probe_sent();
    EXPECT_FALSE(mtu.probe_due(now)) << "one at a time";
    if (*size <= 1452)
      mtu.probe_arrived(*size, now);
    else
      mtu.probe_lost(now);
  }
  EXPECT_EQ(mtu.bytes(), 1452u);
  EXPECT_FALSE(mtu.probe_due(now)) << "the search is over for a while";
  EXPECT_TRUE(mtu.probe_due(now + MtuDiscovery::kSearchAgain));
}

TEST(MtuDiscovery, FallsBackWhenLongDatagramsVanish) {
  MtuDiscovery mtu;
  mtu.probe_sent();
  mtu.probe_arrived(1280, kStart);
  for (uint32_t i = 1; i < MtuDiscovery::kBlackHole; ++i) mtu.lost(1280, kStart);
  mtu.arrived(1280);
  for (uint32_t i = 1; i < MtuDiscovery::kBlackHole; ++i) mtu.lost(1280, kStart);
  for (int i = 0; i < 100; ++i) mtu.lost(1000, kStart);
  EXPECT_EQ(mtu.bytes(), 1280u);
  mtu.lost(1280, kStart);
  EXPECT_EQ(mtu.bytes(), protocol::kMaxDatagramBytes);
}

TEST(MtuDiscovery, FallsBackInSilenceAndSearchesAnew) {
  MtuDiscovery mtu;
  mtu.probe_sent();
  mtu.probe_arrived(1280, kStart);
  mtu.silent(kStart);
  EXPECT_EQ(mtu.bytes(), protocol::kMaxDatagramBytes);
  EXPECT_FALSE(mtu.probe_due(kStart));
  EXPECT_TRUE(mtu.probe_due(kStart + MtuDiscovery::kAfterBlackHole));
}

TEST(MtuDiscovery, EverySearchTriesASizeThreeTimes) {
  MtuDiscovery mtu;
  TimePoint now = kStart;
  mtu.probe_sent();
  mtu.probe_arrived(1280, now);
  mtu.silent(now);
  for (int search = 0; search < 3; ++search) {
    now += MtuDiscovery::kSearchAgain;
    uint32_t tries = 0;
    for (; mtu.probe_due(now); now += MtuDiscovery::kBetweenProbes, ++tries) {
      mtu.probe_sent();
      mtu.probe_lost(now);
    }
    EXPECT_EQ(tries, MtuDiscovery::kTries) << search;
  }
}

TEST(RequestGate, HoldsViewsBackWhileTheLinkIsBusy) {
  RequestGate gate;
  gate.asked(FrameId{1}, kStart);
  gate.answered(FrameId{1}, 100000, kStart + 10ms);
  EXPECT_TRUE(gate.open(0, 1e6, kStart + 10ms));
  EXPECT_FALSE(gate.open(100000, 1e6, kStart + 10ms)) << "the frame before takes another 100 ms";
  EXPECT_GT(gate.opens_at(100000, 1e6, kStart + 10ms), kStart + 90ms);
  EXPECT_TRUE(gate.open(1000, 1e6, kStart + 10ms));
}

TEST(RequestGate, ViewsThatAreNeverAnsweredAreForgotten) {
  RequestGate gate;
  gate.asked(FrameId{1}, kStart);
  gate.answered(FrameId{1}, 100000, kStart);
  for (uint32_t i = 2; i < 10; ++i) gate.asked(FrameId{i}, kStart);
  EXPECT_FALSE(gate.open(0, 1e6, kStart + 100ms));
  EXPECT_TRUE(gate.open(0, 1e6, kStart + 600ms));
}

TEST(ArrivalReport, SpeaksOfEveryDatagramThreeTimes) {
  client::ArrivalReport report;
  EXPECT_EQ(report.due_at(), TimePoint::max());
  std::map<uint64_t, int> spoken;
  TimePoint now = kStart;
  for (uint64_t s = 1; s <= 30; ++s, now += 5ms) {
    if (s % 7 != 0) report.received(s, now);
    if (report.due_at() > now) continue;
    const auto said = report.take(now);
    for (uint64_t i = 0; i < said.count; ++i) {
      EXPECT_EQ(said.ages[i] == 0, (said.first + i) % 7 == 0);
      ++spoken[said.first + i];
    }
    EXPECT_EQ(report.due_at(), TimePoint::max());
  }
  for (uint64_t s = 1; s <= 20; ++s) EXPECT_EQ(spoken[s], 3) << s;
}

TEST(ArrivalReport, ManyArrivalsDoNotWaitAndAreNotTooMany) {
  client::ArrivalReport report;
  report.received(1, kStart);
  report.take(kStart);
  for (uint64_t s = 2; s < 2 + client::ArrivalReport::kMany; ++s) report.received(s, kStart + 1ms);
  EXPECT_LE(report.due_at(), kStart + 1ms);
  for (uint64_t s = 100; s < 3000; ++s) report.received(s, kStart + 2ms);
  const auto said = report.take(kStart + 3ms);
  EXPECT_EQ(said.count, protocol::kMaxReported);
  EXPECT_EQ(said.first + said.count, 3000u);
  report.received(uint64_t{1} << 40, kStart + 4ms);
  EXPECT_EQ(report.take(kStart + 20ms).count, 1u) << "what lies in between was never there";
}

// A frame of `count` slices of one tile each.
protocol::EncodedFrame frame_of(uint32_t frame, uint16_t count, size_t payload = 100) {
  protocol::EncodedFrame made;
  made.offsets.push_back(0);
  for (uint16_t i = 0; i < count; ++i) {
    protocol::SliceHeader header;
    header.frame = FrameId{frame};
    header.slice = i;
    header.slice_count = count;
    header.first_tile = i;
    header.tile_count = header.light_count = 1;
    made.slices.push_back(header);
    made.bytes.resize(made.bytes.size() + payload, static_cast<uint8_t>(i + 1));
    made.offsets.push_back(made.bytes.size());
  }
  return made;
}

TEST(SliceRecovery, RebuildsWhatParityAllows) {
  StoredFrame frame(frame_of(1, 40), 1, kStart);
  frame.protect(0.05);
  client::SliceRecovery recovery;
  const auto header_of = [&](uint16_t slice) { return protocol::decode_frame_slice(frame.body(slice))->header; };
  for (uint16_t i = 0; i < 40; ++i) {
    if (i == 4 || i == 7) continue;
    EXPECT_TRUE(recovery.add_slice(header_of(i), frame.body(i)).empty());
  }
  std::vector<Bytes> rebuilt;
  for (uint16_t i = 0; i < frame.parity_count(); ++i) {
    const auto parity = protocol::decode_parity(frame.parity_body(i));
    ASSERT_TRUE(parity);
    EXPECT_EQ(parity->header.reserved, 0);
    for (auto& body : recovery.add_parity(*parity)) rebuilt.push_back(body);
  }
  ASSERT_EQ(rebuilt.size(), 2u);
  for (const Bytes& body : rebuilt) {
    const auto slice = protocol::decode_frame_slice(body);
    ASSERT_TRUE(slice);
    EXPECT_TRUE(slice->header.slice == 4 || slice->header.slice == 7);
    EXPECT_TRUE(std::equal(body.begin(), body.end(), frame.body(slice->header.slice).begin()));
  }
}

TEST(SliceRecovery, WorksWhenParityOvertakesSlices) {
  StoredFrame frame(frame_of(1, 4), 1, kStart);
  frame.protect(0.05);
  client::SliceRecovery recovery;
  EXPECT_TRUE(recovery.add_parity(*protocol::decode_parity(frame.parity_body(0))).empty());
  size_t rebuilt = 0;
  for (uint16_t i = 1; i < 4; ++i) {
    rebuilt += recovery.add_slice(protocol::decode_frame_slice(frame.body(i))->header, frame.body(i)).size();
  }
  EXPECT_EQ(rebuilt, 1u);
}

TEST(StoredFrame, PaddingMakesSlicesOfOneLength) {
  protocol::EncodedFrame slices = frame_of(1, 5);
  slices.offsets = {0, 100, 195, 290, 390, 420};  // 100, 95, 95, 100 and 30 bytes
  const StoredFrame frame(slices, 1, kStart, true), plain(slices, 1, kStart);
  for (uint16_t i = 0; i < 5; ++i) {
    EXPECT_EQ(frame.body(i).size(), i == 4 ? plain.body(i).size() : frame.body(0).size()) << i;
    const auto slice = protocol::decode_frame_slice(frame.body(i));
    ASSERT_TRUE(slice);
    EXPECT_TRUE(std::equal(slice->payload.begin(), slice->payload.end(), slices.payload(i).begin(),
                           slices.payload(i).end()));
  }
}

TEST(StoredFrame, WhatParityCoversDoesNotGoAgain) {
  StoredFrame frame(frame_of(1, 32), 1, kStart);
  EXPECT_TRUE(frame.slice_lost(3)) << "without parity";
  StoredFrame covered(frame_of(1, 32), 1, kStart);
  covered.protect(0.01);
  const auto parity = static_cast<uint16_t>(covered.parity_count());
  for (uint16_t i = 0; i < parity; ++i) EXPECT_FALSE(covered.slice_lost(i));
  EXPECT_TRUE(covered.slice_lost(20));
  covered.slice_arrived(21);
  EXPECT_FALSE(covered.slice_lost(21)) << "it has come after all";
}

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

// Frames of one small slice, and the probes between them, all of which arrive up to that size.
Probed probe_up_to(LinkSender& link, size_t bytes) {
  Probed path{0, kStart};
  for (uint32_t frame = 1000; link.datagram_bytes() < bytes && frame < 1100; ++frame) {
    link.add(frame_of(frame, 1), TimePoint::max(), path.now);
    for (const TimePoint until = path.now + 20ms; path.now < until; path.now += 1ms) {
      while (const auto out = link.next(path.now)) {
        link.sent(++path.sent, out->body.size() + protocol::kHeaderBytes + protocol::kTagBytes, path.now);
        const auto now_us = static_cast<uint64_t>(to_microseconds(path.now.time_since_epoch()));
        link.hear(all_arrived(path.sent, path.sent, now_us), path.now + 1ms);
      }
    }
  }
  return path;
}

TEST(LinkSender, WithoutFeedbackEverythingGoesAtOnce) {
  LinkSender link(0);
  link.add(frame_of(1, 50), TimePoint::max(), kStart);
  uint64_t sent = 0;
  while (link.next(kStart)) link.sent(++sent, 200, kStart);
  EXPECT_EQ(sent, 50u);
  EXPECT_EQ(link.wake_at(kStart), TimePoint::max());
  EXPECT_TRUE(link.takes_view(kStart));
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
    LinkSender link(protocol::kFeatureFeedback, resumed);
    protocol::Feedback said;
    said.recovered = 7;
    said.incomplete = 9;
    link.hear(said, kStart);
    EXPECT_EQ(link.counters().recovered, resumed ? 0u : 7u);
    EXPECT_EQ(link.counters().incomplete, resumed ? 0u : 9u);
    said.recovered = 8;
    said.incomplete = 11;
    link.hear(said, kStart + 10ms);
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

// The path takes long datagrams no more, and the client asks for nothing new before it has its answer.
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
  EXPECT_TRUE(link.takes_view(now));
  EXPECT_EQ(link.datagram_bytes(), protocol::kMaxDatagramBytes);

  // What was known of the first answer's slices says nothing of the second's.
  link.add(frame_of(1, 1), TimePoint::max(), now);
  link.hear(all_arrived(path.sent + 1, sent, 1000), now + 1ms);
  EXPECT_FALSE(link.take_lost(FrameId{2}, now + 1ms));
  const auto out = link.next(now + 1ms);
  ASSERT_TRUE(out);
  const auto slice = protocol::decode_frame_slice(out->body);
  ASSERT_TRUE(slice);
  EXPECT_EQ(slice->header.slice_count, 1u);
}

// 90 ms away, a tenth lost: frames have parity.
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
    link.hear(said, now + 90ms);
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
  link.hear(all_arrived(1, 1, 1000), now);
  EXPECT_FALSE(link.take_lost(FrameId{1}, now + 10s));
}

TEST(LinkSender, NothingGoesAfterItsDeadline) {
  LinkSender link(protocol::kFeatureFeedback);
  link.add(frame_of(1, 50, 1000), kStart + 20ms, kStart);
  uint64_t sent = 0;
  while (link.next(kStart)) link.sent(++sent, 1068, kStart);
  EXPECT_FALSE(link.next(kStart + 20ms));
  EXPECT_EQ(link.counters().too_late, 50 - sent);
}

// Sends all of a frame, loses slice 2, and tells so at `heard`.
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
  link.hear(said, heard);
  said.time_us += 30000;
  link.hear(said, heard + 30ms);
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
