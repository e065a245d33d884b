// Nodes whose wall clocks agree show one moment, however late each of them starts.
#include "daemon/scenes/scene_clock.h"

#include <gtest/gtest.h>

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;
using WallTime = std::chrono::system_clock::time_point;

constexpr WallTime kNoon{1'800'000'000s};

// How long the clock of a process that starts at `now`, when it is `wall`, has run when it is `asked` by the wall.
Nanoseconds played(const Config& config, TimePoint now, WallTime wall, WallTime asked) {
  return now + (asked - wall) - scene_clock_start(config, now, wall);
}

TEST(SceneClock, BeginsWithTheDaemon) {
  EXPECT_EQ(played(Config(), TimePoint(7s), kNoon, kNoon), 0s);
  EXPECT_EQ(played(Config(), TimePoint(7s), kNoon, kNoon + 3s), 3s);
}

TEST(SceneClock, IsTheWallClockInAFleet) {
  Config config;
  config.fleet.door_listen = "127.0.0.1";
  const Nanoseconds early = played(config, TimePoint(7s), kNoon, kNoon + 1h);
  const Nanoseconds late = played(config, TimePoint(99s), kNoon + 59min, kNoon + 1h);
  EXPECT_EQ(early, late);
  EXPECT_EQ(early, (kNoon + 1h).time_since_epoch());
}

TEST(SceneClock, IsWhatTheConfigurationSays) {
  Config config;
  config.scenes.clock = SceneClock::wall;
  EXPECT_EQ(played(config, TimePoint(7s), kNoon, kNoon), kNoon.time_since_epoch());
  config.scenes.clock = SceneClock::start;
  config.fleet.door_listen = "127.0.0.1";
  EXPECT_EQ(played(config, TimePoint(7s), kNoon, kNoon), 0s);
}

}  // namespace
}  // namespace gnomon::daemon
