// How many frames a session was sent, and how long they took.
#pragma once

#include "daemon/frame/frame.h"
#include "protocol/messages.h"

namespace gnomon::daemon {

// Belongs to the net thread.
class SessionTotals {
 public:
  void add(const FrameMeta& meta, TimePoint sent);  // adds a frame that was sent completely

  // Totals of the session, and means since the last call (0 for an interval without frames).
  protocol::Stats take_stats();

 private:
  struct Sums {
    uint32_t frames = 0;
    Nanoseconds queue{}, gpu{}, total{};
  };

  uint64_t frames_ = 0;
  uint64_t coalesced_ = 0;
  Sums recent_;
};

}  // namespace gnomon::daemon
