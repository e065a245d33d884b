// Over how much time a frame's datagrams are spread, where the rate would allow less: what pacing costs every frame. Pure.
//
// A burst that is longer than the path's queues loses its end, so that a session begins with a wide spread (pacing as
// RFC 9002, 7.7 asks for). While reports tell of neither losses nor a queue it narrows, down to what goes by one wake-up;
// the first sign of either doubles it.
#pragma once

#include <algorithm>

#include "common/clock.h"
#include "daemon/link/pacer.h"

namespace gnomon::daemon {

class FrameSpread {
 public:
  static constexpr Nanoseconds kWidest = std::chrono::milliseconds(4);
  static constexpr Nanoseconds kNarrowest = Pacer::kBatch;
  static constexpr Nanoseconds kShortQueue = std::chrono::milliseconds(1);  // no sign of anything
  static constexpr Nanoseconds kLongQueue = std::chrono::milliseconds(2);

  Nanoseconds current() const { return spread_; }

  // One report of the client: datagrams lost, and how long the last ones queued.
  void observe(uint32_t lost, Nanoseconds queue) {
    if (lost > 0 || queue > kLongQueue) {
      spread_ = std::min(kWidest, 2 * spread_);
    } else if (queue < kShortQueue) {
      spread_ = std::max(kNarrowest, spread_ - spread_ / 8);
    }
  }

 private:
  Nanoseconds spread_ = kWidest;
};

}  // namespace gnomon::daemon
