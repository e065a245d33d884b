// Which datagrams of the server have arrived and when, for the Feedback that lets it measure the path.
//
// Reports overlap: each datagram is spoken of in three of them, so that a lost report costs nothing. Pure.
#pragma once

#include <array>
#include <deque>

#include "common/clock.h"
#include "protocol/feedback.h"

namespace gnomon::client {

class ArrivalReport {
 public:
  static constexpr Nanoseconds kInterval = std::chrono::milliseconds(10);
  static constexpr uint32_t kMany = 64;  // arrivals that do not wait for the interval

  void received(uint64_t sequence, TimePoint at);

  // When the next report should go; max: nothing new.
  TimePoint due_at() const;

  // `recovered` and `incomplete` are left to the caller.
  protocol::Feedback take(TimePoint now);

 private:
  std::deque<TimePoint> arrivals_;  // of sequences first_, first_ + 1 ...; {}: has not arrived
  uint64_t first_ = 1;
  std::array<uint64_t, 2> begins_{1, 1};  // first new sequence of the last two reports, the older one first
  uint64_t reported_ = 0;                 // highest
  uint32_t fresh_ = 0;                    // arrivals not reported
  TimePoint oldest_fresh_ = TimePoint::max();
  TimePoint last_report_{};
};

}  // namespace gnomon::client
