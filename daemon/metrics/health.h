// What the daemon as a whole is doing: written by main and the render thread, read by everybody.
#pragma once

#include <atomic>
#include <chrono>

#include "common/clock.h"

namespace gnomon::daemon {

// As long as a unit's WatchdogSec: what no watchdog guards, as a container, is guarded by whoever asks for our health.
constexpr std::chrono::seconds kHung{10};

struct Health {
  std::atomic<bool> scenes_loaded{false};
  std::atomic<bool> device_up{false};
  std::atomic<bool> draining{false};

  std::atomic<TimePoint> alive_at{TimePoint::max()};  // every render thread gave a sign; max: nobody looks yet

  bool ready() const { return scenes_loaded && device_up && !draining; }
  bool hangs(TimePoint now) const { return now > alive_at.load() && now - alive_at.load() > kHung; }
};

}  // namespace gnomon::daemon
