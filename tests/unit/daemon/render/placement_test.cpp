// On which device sessions are placed: spread by their load, and moved when a device closes or opens.
#include "daemon/render/placement.h"

#include <gtest/gtest.h>

namespace gnomon::daemon {
namespace {

constexpr TenantId kOne{1}, kTwo{2};

TEST(Placement, PutsASessionWhereLeastIsAskedFor) {
  Placement places(2);
  EXPECT_EQ(places.add(SessionId{1}, kOne, 10), 0u);
  EXPECT_EQ(places.add(SessionId{2}, kOne, 4), 1u);
  EXPECT_EQ(places.add(SessionId{3}, kOne, 4), 1u);
  EXPECT_EQ(places.add(SessionId{4}, kOne, 1), 1u);
  EXPECT_EQ(places.add(SessionId{5}, kOne, 1), 1u);
  EXPECT_EQ(places.add(SessionId{6}, kOne, 1), 0u) << "both have 10";
  places.remove(SessionId{1});
  EXPECT_EQ(places.add(SessionId{7}, kOne, 1), 0u);
  EXPECT_EQ(places.device_of(SessionId{7}), 0u);
  EXPECT_FALSE(places.device_of(SessionId{1}));
}

TEST(Placement, SpreadsTheSessionsOfAClosedDeviceOverTheOthers) {
  Placement places(3);
  for (uint64_t s = 0; s < 9; ++s) places.add(SessionId{s}, kOne, 1);
  const auto moves = places.close(1);
  EXPECT_EQ(moves.size(), 3u);
  for (const auto& move : moves) {
    EXPECT_EQ(move.from, 1u);
    EXPECT_EQ(places.device_of(move.session), move.to);
  }
  EXPECT_EQ(places.sessions(1), 0u);
  EXPECT_EQ(places.sessions(0) + places.sessions(2), 9u);
  EXPECT_LE(places.sessions(0), 5u);
  EXPECT_LE(places.sessions(2), 5u);
  EXPECT_NE(places.add(SessionId{10}, kOne, 1), 1u);
}

TEST(Placement, KeepsSessionsWhereThereIsNoOtherDevice) {
  Placement one(1);
  one.add(SessionId{1}, kOne, 1);
  EXPECT_TRUE(one.close(0).empty());
  EXPECT_EQ(one.device_of(SessionId{1}), 0u);
  EXPECT_EQ(one.add(SessionId{2}, kOne, 1), 0u) << "it may come back";
  Placement two(2);
  two.add(SessionId{1}, kOne, 1);
  two.close(1);
  EXPECT_TRUE(two.close(0).empty());
  EXPECT_EQ(two.open(1).size(), 1u) << "who was left on a closed device moves to the first that opens";
}

TEST(Placement, SharesAgainWhenADeviceOpens) {
  Placement places(2);
  for (uint64_t s = 0; s < 8; ++s) places.add(SessionId{s}, kOne, 1);
  places.close(0);
  ASSERT_EQ(places.sessions(1), 8u);
  EXPECT_EQ(places.open(0).size(), 4u);
  EXPECT_EQ(places.sessions(0), 4u);
  EXPECT_TRUE(places.open(0).empty()) << "it is open";
}

TEST(Placement, NeverOpensADeviceThatIsGone) {
  Placement places(2);
  places.close_for_ever(0);
  EXPECT_TRUE(places.open(0).empty());
  EXPECT_FALSE(places.is_open(0));
  EXPECT_EQ(places.add(SessionId{1}, kOne, 1), 1u);
  places.close_for_ever(1);
  EXPECT_FALSE(places.add(SessionId{2}, kOne, 1));
}

TEST(Placement, SaysWhatPartOfATenantADeviceHas) {
  Placement places(2);
  places.add(SessionId{1}, kOne, 3);  // device 0
  places.add(SessionId{2}, kTwo, 1);  // device 1
  places.add(SessionId{3}, kOne, 1);  // device 1
  EXPECT_DOUBLE_EQ(places.fraction(0, kOne), 0.75);
  EXPECT_DOUBLE_EQ(places.fraction(1, kOne), 0.25);
  EXPECT_DOUBLE_EQ(places.fraction(1, kTwo), 1);
  EXPECT_DOUBLE_EQ(places.fraction(0, kTwo), 0);
  places.remove(SessionId{1});
  EXPECT_DOUBLE_EQ(places.fraction(1, kOne), 1);
}

}  // namespace
}  // namespace gnomon::daemon
