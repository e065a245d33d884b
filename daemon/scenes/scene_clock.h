// Where the clock that all animations play on begins.
#pragma once

#include <chrono>

#include "common/clock.h"
#include "daemon/config/config.h"

namespace gnomon::daemon {

// Time 0 of the clock of all scenes, by this process's clock. By the wall clock it is the beginning of 1970 (UTC), so that
// nodes whose clocks agree show one moment of a scene, however late they start. It is asked once, at the start: a wall
// clock that is set later does not make a scene jump.
inline TimePoint scene_clock_start(const Config& config, TimePoint now,
                                   std::chrono::system_clock::time_point wall) {
  const SceneClock clock = config.scenes.clock;
  const bool in_fleet = !config.fleet.door_listen.empty();
  const bool by_wall = clock == SceneClock::wall || (clock == SceneClock::by_fleet && in_fleet);
  return by_wall ? now - std::chrono::duration_cast<Nanoseconds>(wall.time_since_epoch()) : now;
}

}  // namespace gnomon::daemon
