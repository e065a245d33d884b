// Signs of life of the render thread, for a watchdog on another thread.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

#include "common/clock.h"

namespace gnomon::daemon {

class Heartbeat {
 public:
  // The render thread: something was finished, or there is nothing to do.
  void beat() {
    excused_until_ = TimePoint::min().time_since_epoch().count();
    beats_.fetch_add(1);
  }
  // Until then it may say nothing: it does what takes long.
  void excuse_until(TimePoint time) { excused_until_ = time.time_since_epoch().count(); }
  // It ended, as it should.
  void end() { ended_ = true; }

  // One other thread: whether there was a sign since the last call.
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
