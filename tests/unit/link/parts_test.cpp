// The small parts of a session's link, each tested alone.
#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <set>

#include "client/net/arrival_report.h"
#include "client/stream/slice_recovery.h"
#include "daemon/link/link_sender.h"
#include "daemon/link/omitted_numbers.h"
#include "daemon/link/parity_plan.h"
#include "tests/unit/link/made_frame.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<uint8_t>;

constexpr TimePoint kStart{10s};

TEST(QueueDelay, IsWhatGoesBeyondTheLeastWhateverTheClocksSay) {
  QueueDelay queue;
  for (int i = 0; i < 10; ++i) queue.add(-1h + 20ms, kStart);
  EXPECT_EQ(queue.current(), 0ms);
  for (int i = 0; i < 4; ++i) queue.add(-1h + 32ms, kStart);
  EXPECT_EQ(queue.current(), 12ms);
  queue.add(-1h + 21ms, kStart);
  EXPECT_EQ(queue.current(), 1ms) << "one that came through tells that there is no queue";
}

TEST(QueueDelay, ForgetsAnOldPathInAMinute) {
  QueueDelay queue;
  for (int i = 0; i < 4; ++i) queue.add(10ms, kStart);
  for (int s = 1; s < 90; ++s) {
    for (int i = 0; i < 4; ++i) queue.add(50ms, kStart + s * 1s);
  }
  EXPECT_EQ(queue.current(), 0ms);
}

TEST(ClientClock, FollowsAnHonestClockOfAnyOrigin) {
  for (const uint64_t origin : {uint64_t{0}, uint64_t{1} << 40, uint64_t{1} << 63, ~uint64_t{0} - 1000}) {
    ClientClock clock;
    EXPECT_EQ(clock.read(origin, kStart), kStart);
    EXPECT_EQ(clock.read(origin + 5000, kStart + 6ms), kStart + 5ms) << origin;
    EXPECT_EQ(clock.read(origin - 5000, kStart + 7ms), kStart - 5ms) << "set back a little";
  }
}

TEST(ClientClock, IsNeverFarFromOursWhateverTheClientSays) {
  std::mt19937_64 random(4);
  for (int client = 0; client < 1000; ++client) {
    ClientClock clock;
    TimePoint now = kStart;
    for (int i = 0; i < 20; ++i, now += 10ms) {
      const TimePoint read = clock.read(random() >> random() % 64, now);
      EXPECT_LE(read, now + ClientClock::kMostOff);
      EXPECT_GE(read, now - ClientClock::kMostOff);
    }
  }
}

TEST(DeliveryRate, IsOfTheLastTenthOfASecond) {
  DeliveryRate rate;
  EXPECT_EQ(rate.bytes_per_second(), 0);
  for (int i = 0; i < 1000; ++i) rate.arrived(kStart + i * 1ms, 500);
  EXPECT_NEAR(rate.bytes_per_second(), 500e3, 10e3);
}

TEST(DeliveryRate, AClockThatWasSetBackBeginsAnewAndOneThatTremblesDoesNot) {
  DeliveryRate rate;
  for (int i = 0; i < 100; ++i) rate.arrived(kStart + i * 1ms - i % 3 * 2ms, 500);
  EXPECT_NEAR(rate.bytes_per_second(), 500e3, 20e3);
  for (int i = 0; i < 100; ++i) rate.arrived(kStart - 1h + i * 1ms, 100);
  EXPECT_NEAR(rate.bytes_per_second(), 100e3, 5e3);
}

// As many arrivals as a fast session has in a minute, by a clock that stands still, runs backwards or jumps.
TEST(DeliveryRate, CostsLittleWhateverTheClockDoes) {
  std::mt19937_64 random(4);
  const std::vector<std::function<Nanoseconds(int)>> clocks{
      [](int) { return 0s; }, [](int i) { return i * -1us; }, [](int i) { return i * -1ms; },
      [&](int) { return std::chrono::seconds(random() % 3600); }};
  for (const auto& clock : clocks) {
    DeliveryRate rate;
    size_t most = 0;
    for (int i = 0; i < 1'000'000; ++i) {
      rate.arrived(kStart + 2h + clock(i), 1000);
      most = std::max(most, rate.remembered());
    }
    EXPECT_LE(most, size_t{1} << 14);
    EXPECT_GT(rate.bytes_per_second(), 0);
  }
}

// Reports a second that an honest client sends when datagrams arrive evenly.
TEST(FeedbackAllowance, IsTwiceWhatHonestClientsSend) {
  for (const auto& [datagrams, expected] :
       {std::pair(50, 50), {1'000, 100}, {6'000, 100}, {24'000, 375}, {100'000, 1'563}}) {
    client::ArrivalReport report;
    FeedbackAllowance allowance;
    int reports = 0, refused = 0, spare = 0;
    const Nanoseconds gap = Nanoseconds(1s) / datagrams;
    for (int i = 0; i < 4 * datagrams; ++i) {
      const TimePoint now = kStart + i * gap;
      allowance.sent();
      report.received(static_cast<uint64_t>(i) + 1, now);
      if (report.due_at() > now) continue;
      report.take(now);
      ++reports;
      refused += !allowance.take(now);
      spare += allowance.take(now);
    }
    EXPECT_NEAR(reports / 4, expected, expected / 50 + 1) << datagrams;
    EXPECT_EQ(refused, 0) << datagrams << " a second";
    EXPECT_GT(spare, reports * 9 / 10) << "twice as many are let through";
  }
}

TEST(FeedbackAllowance, AFloodGetsTwoHundredASecondAndItsFirstFew) {
  FeedbackAllowance allowance;
  int taken = 0;
  for (TimePoint now = kStart; now < kStart + 10s; now += 50us) taken += allowance.take(now);
  EXPECT_NEAR(taken, 10 * FeedbackAllowance::kPerSecond + FeedbackAllowance::kMost, 2);
}

TEST(OmittedNumbers, AreSparseAndNotToBeForeseen) {
  OmittedNumbers omitted([random = std::mt19937_64(1)]() mutable { return random(); });
  std::set<int> runs;
  int count = 0;
  for (int i = 0, run = 0; i < 100'000; ++i, ++run) {
    if (!omitted.omit_next()) continue;
    EXPECT_LT(run, static_cast<int>(OmittedNumbers::kLongestRun));
    runs.insert(run);
    run = -1;
    ++count;
  }
  EXPECT_NEAR(count, 100'000 / 128.5, 60);
  EXPECT_GT(runs.size(), OmittedNumbers::kLongestRun * 9 / 10) << "every length comes";
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

// The share of many simulated groups with that much parity that cannot be rebuilt.
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
    mtu.probe_sent(now);
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

// What remembers it may have had to make room, so that neither its arrival nor its loss is ever reported.
TEST(MtuDiscovery, AProbeOfWhichNothingIsHeardIsNotWaitedForForEver) {
  MtuDiscovery mtu;
  mtu.probe_sent(kStart);
  EXPECT_FALSE(mtu.probe_due(kStart + MtuDiscovery::kForgotten - 1ms));
  EXPECT_TRUE(mtu.probe_due(kStart + MtuDiscovery::kForgotten));
}

TEST(MtuDiscovery, FallsBackWhenLongDatagramsVanish) {
  MtuDiscovery mtu;
  mtu.probe_sent(kStart);
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
  mtu.probe_sent(kStart);
  mtu.probe_arrived(1280, kStart);
  mtu.silent(kStart);
  EXPECT_EQ(mtu.bytes(), protocol::kMaxDatagramBytes);
  EXPECT_FALSE(mtu.probe_due(kStart));
  EXPECT_TRUE(mtu.probe_due(kStart + MtuDiscovery::kAfterBlackHole));
}

TEST(MtuDiscovery, EverySearchTriesASizeThreeTimes) {
  MtuDiscovery mtu;
  TimePoint now = kStart;
  mtu.probe_sent(kStart);
  mtu.probe_arrived(1280, now);
  mtu.silent(now);
  for (int search = 0; search < 3; ++search) {
    now += MtuDiscovery::kSearchAgain;
    uint32_t tries = 0;
    for (; mtu.probe_due(now); now += MtuDiscovery::kBetweenProbes, ++tries) {
      mtu.probe_sent(now);
      mtu.probe_lost(now);
    }
    EXPECT_EQ(tries, MtuDiscovery::kTries) << search;
  }
}

TEST(RequestGate, HoldsViewsBackWhileTheLinkIsBusy) {
  RequestGate gate;
  gate.on_request(FrameId{1}, kStart);
  gate.on_answer(FrameId{1}, 100000, kStart + 10ms);
  EXPECT_TRUE(gate.open(0, 1e6, kStart + 10ms));
  EXPECT_FALSE(gate.open(100000, 1e6, kStart + 10ms)) << "the frame before takes another 100 ms";
  EXPECT_GT(gate.opens_at(100000, 1e6, kStart + 10ms), kStart + 90ms);
  EXPECT_TRUE(gate.open(1000, 1e6, kStart + 10ms));
}

TEST(RequestGate, ViewsThatAreNeverAnsweredAreForgotten) {
  RequestGate gate;
  gate.on_request(FrameId{1}, kStart);
  gate.on_answer(FrameId{1}, 100000, kStart);
  for (uint32_t i = 2; i < 10; ++i) gate.on_request(FrameId{i}, kStart);
  EXPECT_FALSE(gate.open(0, 1e6, kStart + 100ms));
  EXPECT_TRUE(gate.open(0, 1e6, kStart + 600ms));
}

TEST(RequestGate, OfViewsThatComeFasterThanAnyIsAnsweredItKeepsTheNewest) {
  RequestGate gate;
  gate.on_request(FrameId{1}, kStart);
  gate.on_answer(FrameId{1}, 1000, kStart);
  for (uint32_t i = 2; i < 100'000; ++i) gate.on_request(FrameId{i}, kStart);
  EXPECT_LT(gate.opens_at(0, 1e6, kStart), kStart + 1s) << "of 1 ms each";
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

TEST(SliceRecovery, KeepsNoMoreShardsThanAServerHasUseFor) {
  StoredFrame frame(frame_of(1, 4), 1, kStart);
  frame.protect(0.05);
  auto parity = *protocol::decode_parity(frame.parity_body(0));
  client::SliceRecovery recovery;
  parity.header.groups = 4;
  for (uint32_t i = 0; i < 1024; ++i) {
    parity.header.group = static_cast<uint16_t>(i % 4);
    parity.header.index = static_cast<uint8_t>(i / 4);
    recovery.add_parity(parity);
  }
  EXPECT_LE(recovery.shards(), 2 * 4 + protocol::kMaxGroupParity);
}

TEST(StoredFrame, PaddingMakesSlicesOfOneLength) {
  protocol::EncodedMask slices = frame_of(1, 5);
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

}  // namespace
}  // namespace gnomon::daemon
