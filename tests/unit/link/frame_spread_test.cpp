// Over how much time the datagrams of a frame go: every frame pays for it, and so does the next camera of a client that
// waits for one answer before it asks for another.
#include "daemon/link/frame_spread.h"

#include <gtest/gtest.h>

#include "daemon/link/link_sender.h"
#include "tests/unit/link/made_frame.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

constexpr TimePoint kStart{10s};

TEST(FrameSpread, NarrowsWhileNothingQueuesAndWidensAtTheFirstSign) {
  FrameSpread spread;
  EXPECT_EQ(spread.current(), FrameSpread::kWidest) << "nothing is known of the path";
  for (int i = 0; i < 5; ++i) spread.observe(0, 200us);
  EXPECT_LT(spread.current(), 3ms);
  EXPECT_GT(spread.current(), FrameSpread::kNarrowest);
  for (int i = 0; i < 20; ++i) spread.observe(0, 200us);
  EXPECT_EQ(spread.current(), FrameSpread::kNarrowest);
  spread.observe(0, FrameSpread::kLongQueue);
  EXPECT_EQ(spread.current(), FrameSpread::kNarrowest) << "between the two thresholds nothing changes";
  spread.observe(1, 0us);
  EXPECT_EQ(spread.current(), 2 * FrameSpread::kNarrowest);
  for (int i = 0; i < 3; ++i) spread.observe(0, FrameSpread::kLongQueue + 1us);
  EXPECT_EQ(spread.current(), FrameSpread::kWidest);
}

// The client's report of these datagrams, which all arrived.
protocol::Feedback arrived(uint64_t first, uint64_t last, TimePoint now) {
  protocol::Feedback said;
  said.first = first;
  said.count = static_cast<uint16_t>(last - first + 1);
  said.time_us = static_cast<uint64_t>(to_microseconds(now.time_since_epoch()));
  for (uint64_t i = 0; i < said.count; ++i) said.ages[static_cast<size_t>(i)] = 1;
  return said;
}

TEST(FrameSpread, OnAPathWithoutAQueueAFrameSoonGoesAtOnce) {
  LinkSender link(protocol::kFeatureFeedback);
  uint64_t sent = 0;
  const auto time_to_send = [&](uint32_t frame, TimePoint added) {
    const uint64_t before = sent;
    TimePoint last = added;
    link.add(frame_of(frame, 50, 1000), TimePoint::max(), added);
    for (TimePoint now = added; now < added + 1s && sent < before + 50; now = link.wake_at(now)) {
      const uint64_t first = sent + 1;
      while (const auto out = link.next(now)) {
        link.sent(++sent, out->body.size() + protocol::kHeaderBytes + protocol::kTagBytes, now);
      }
      if (sent < first) continue;
      last = now;
      EXPECT_EQ(link.on_feedback(arrived(first, sent, now), now + 1ms), FeedbackVerdict::taken);
    }
    return last - added;
  };
  for (uint32_t frame = 1; frame < 60; ++frame) time_to_send(frame, kStart + frame * 33ms);
  EXPECT_LE(time_to_send(60, kStart + 60 * 33ms), Pacer::kBatch);
}

}  // namespace
}  // namespace gnomon::daemon
