// The render thread's beats, read by a watchdog on another thread.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

#include "common/clock.h"

namespace gnomon::daemon {

class Heartbeat {
 public:
  // The render thread has finished something or has nothing to do.
  void beat() {
    excused_until_ = TimePoint::min().time_since_epoch().count();
    beats_.fetch_add(1);
  }
  // The render thread starts something that takes long: until then it counts as alive without a beat.
  void excuse_until(TimePoint time) { excused_until_ = time.time_since_epoch().count(); }
  // The render thread has ended in order: from now on it counts as alive.
  void end() { ended_ = true; }

  // For one other thread: true if the render thread has beaten since the last call, is excused or has ended.
  bool lives(TimePoint now) {
    const uint64_t beats = beats_;
    const bool moved = beats != seen_;
    seen_ = beats;
    return moved || ended_ || now.time_since_epoch().count() < excused_until_;
  }

 private:
  std::atomic<uint64_t> beats_{0};
  std::atomic<TimePoint::rep> excused_until_{TimePoint::min().time_since_epoch().count()};
  std::atomic<bool> ended_{false};
  uint64_t seen_ = 0;
};

}  // namespace gnomon::daemon
