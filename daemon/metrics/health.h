// The state of the daemon as a whole. Any thread reads and writes it.
#pragma once

#include <atomic>
#include <chrono>

#include "common/clock.h"

namespace gnomon::daemon {

// As long as WatchdogSec in the systemd unit. Without a watchdog, as in a container, /healthz takes its place.
constexpr std::chrono::seconds kHung{10};

struct Health {
  std::atomic<bool> serving{false};  // the devices are open; clients that came before wait for it
  std::atomic<bool> scenes_loaded{false};
  std::atomic<bool> device_up{false};
  std::atomic<bool> draining{false};  // an operator wants nobody admitted; who is here is served on
  std::atomic<bool> stopping{false};  // for good

  // When every render thread was last found alive; max: not checked yet.
  std::atomic<TimePoint> alive_at{TimePoint::max()};

  // Whether frames are answered, those of sessions that there are if no others are let in.
  bool serves(TimePoint now) const { return scenes_loaded && device_up && !hangs(now); }
  bool admits() const { return !draining && !stopping; }
  bool ready() const { return scenes_loaded && device_up && admits(); }
  bool hangs(TimePoint now) const { return now > alive_at.load() && now - alive_at.load() > kHung; }
};

}  // namespace gnomon::daemon
