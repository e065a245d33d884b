#include "daemon/service/watchdog.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

struct Watched {
  Heartbeat one, other;
  std::atomic<int> signs{0};
  Watchdog watchdog{{&one, &other}, [this](TimePoint) { ++signs; }, [] { return std::string("two devices"); }};
};

TEST(Watchdog, DevicesThatBeatAtDifferentMomentsAreAlive) {
  Watched watched;
  // Idle ones beat once a second; these do it half a second after each other and between looks: none finds both.
  std::this_thread::sleep_for(250ms);
  for (int turn = 0; turn < 6; ++turn) {
    (turn % 2 == 0 ? watched.one : watched.other).beat();
    std::this_thread::sleep_for(500ms);
  }
  EXPECT_GE(watched.signs, 1);
}

TEST(Watchdog, OneThatHangsIsNotMadeUpForByAnother) {
  Watched watched;
  for (int turn = 0; turn < 20; ++turn) {
    std::this_thread::sleep_for(100ms);
    watched.one.beat();
  }
  EXPECT_EQ(watched.signs, 0);
}

TEST(Watchdog, OneThatEndedIsNotMissed) {
  Watched watched;
  watched.other.end();
  for (int turn = 0; turn < 15; ++turn) {
    std::this_thread::sleep_for(100ms);
    watched.one.beat();
  }
  EXPECT_GE(watched.signs, 1);
}

}  // namespace
}  // namespace gnomon::daemon
