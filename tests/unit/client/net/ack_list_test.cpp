#include "client/net/ack_list.h"

#include <gtest/gtest.h>

namespace gnomon::client {
namespace {

protocol::CameraUpdate filled(AckList& acks) {
  protocol::CameraUpdate update;
  acks.fill(update);
  return update;
}

TEST(AckList, GathersSlicesOfAFrameIntoOneEntryPerSixtyFour) {
  AckList acks;
  for (const uint16_t slice : {0, 3, 63, 64, 130}) acks.received(FrameId{9}, slice);
  const auto update = filled(acks);
  ASSERT_EQ(update.ack_count, 3);
  EXPECT_EQ(update.acks[2], (protocol::SliceAck{FrameId{9}, 0, 1ull | 1ull << 3 | 1ull << 63}));
  EXPECT_EQ(update.acks[1], (protocol::SliceAck{FrameId{9}, 64, 1}));
  EXPECT_EQ(update.acks[0], (protocol::SliceAck{FrameId{9}, 128, 1ull << 2}));
}

TEST(AckList, RepeatsEveryEntryAFewTimesAndThenStops) {
  AckList acks;
  acks.received(FrameId{1}, 5);
  for (int i = 0; i < AckList::kRepeats; ++i) EXPECT_EQ(filled(acks).ack_count, 1);
  EXPECT_EQ(filled(acks).ack_count, 0);
  acks.received(FrameId{1}, 6);  // another slice of the same frame
  EXPECT_EQ(filled(acks).ack_count, 1);
}

TEST(AckList, SendsTheNewestFirstAndForgetsTheOldest) {
  AckList acks;
  for (uint32_t frame = 1; frame <= 1000; ++frame) acks.received(FrameId{frame}, 0);
  const auto update = filled(acks);
  ASSERT_EQ(update.ack_count, protocol::kMaxAcks);
  for (uint32_t i = 0; i < update.ack_count; ++i) EXPECT_EQ(update.acks[i].frame, FrameId{1000 - i});
  size_t sent = update.ack_count;
  for (size_t more = 1; more > 0; sent += more) more = filled(acks).ack_count;
  EXPECT_LE(sent, 4 * protocol::kMaxAcks * AckList::kRepeats);
}

}  // namespace
}  // namespace gnomon::client
