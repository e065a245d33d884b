#include "daemon/service/liveness.h"

#include <gtest/gtest.h>

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

constexpr TimePoint kStart{std::chrono::hours(1)};

struct TwoDevices {
  Heartbeat one, other;
  Liveness liveness{{&one, &other}};
};

TEST(Liveness, DevicesThatBeatAtDifferentMomentsAreAlive) {
  TwoDevices devices;
  devices.one.beat();
  EXPECT_FALSE(devices.liveness.check(kStart));
  devices.other.beat();
  EXPECT_TRUE(devices.liveness.check(kStart + 500ms)) << "though no check has seen both beats";
  EXPECT_FALSE(devices.liveness.check(kStart + 1s)) << "and both must beat again";
}

TEST(Liveness, OneThatHangsIsNotMadeUpForByAnother) {
  TwoDevices devices;
  for (int turn = 0; turn < 20; ++turn) {
    devices.one.beat();
    EXPECT_FALSE(devices.liveness.check(kStart + turn * 500ms));
  }
}

TEST(Liveness, OneThatEndedIsNotMissed) {
  TwoDevices devices;
  devices.other.end();
  EXPECT_FALSE(devices.liveness.check(kStart));
  devices.one.beat();
  EXPECT_TRUE(devices.liveness.check(kStart + 500ms));
}

TEST(Liveness, OneThatIsExcusedIsAliveUntilThen) {
  TwoDevices devices;
  devices.other.excuse_until(kStart + 5min);
  devices.one.beat();
  EXPECT_TRUE(devices.liveness.check(kStart));
  devices.one.beat();
  EXPECT_FALSE(devices.liveness.check(kStart + 5min));
}

TEST(Liveness, ABeatEndsTheExcuse) {
  TwoDevices devices;
  devices.other.excuse_until(kStart + 5min);
  devices.other.beat();
  devices.one.beat();
  EXPECT_TRUE(devices.liveness.check(kStart)) << "by its beat";
  devices.one.beat();
  EXPECT_FALSE(devices.liveness.check(kStart + 1s));
}

}  // namespace
}  // namespace gnomon::daemon
