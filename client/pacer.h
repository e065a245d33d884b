// When the next camera is sent: at a steady rate, within a window of unanswered cameras, and again after a while
// of silence. Time is an argument. One thread.
#pragma once

#include <cstddef>

#include "common/clock.h"

namespace gnomon::client {

struct PaceOptions {
  double rate_hz = 0;        // 0: as soon as the window allows
  size_t max_in_flight = 1;  // 0: no window; then there must be a rate
  // A full window waits this long since the last camera, then another is sent: the server may have lost them all.
  Nanoseconds retry = std::chrono::seconds(1);
};

class Pacer {
 public:
  // The first camera may be sent at `start`.
  Pacer(const PaceOptions& options, TimePoint start) : options_(options), next_by_rate_(start), last_sent_(start) {}

  // The next camera's time, in the past if it may be sent at once.
  TimePoint next_send(size_t in_flight) const;

  void sent(TimePoint now);

 private:
  PaceOptions options_;
  TimePoint next_by_rate_;
  TimePoint last_sent_;
};

}  // namespace gnomon::client
