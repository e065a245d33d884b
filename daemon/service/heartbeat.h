// The progress of a render thread, for a watchdog on another thread.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

#include "common/clock.h"

namespace gnomon::daemon {

class Heartbeat {
 public:
  // The render thread: something was finished, or the thread is idle.
  void beat() {
    excused_until_ = TimePoint::min().time_since_epoch().count();
    beats_.fetch_add(1);
  }
  // The render thread: no beat() is expected until `time`, because of a long operation.
  void excuse_until(TimePoint time) { excused_until_ = time.time_since_epoch().count(); }
  // The render thread has ended regularly.
  void end() { ended_ = true; }

  // The watchdog's thread: whether there was a beat() since the last call, or none is expected.
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
