// Records which of the server's datagrams have arrived and when, for the Feedback from which it measures the path.
//
// Reports overlap: each datagram is covered by three of them, so that a lost report costs nothing. Time is an argument.
// One thread.
#pragma once

#include <array>
#include <deque>

#include "common/clock.h"
#include "protocol/feedback.h"

namespace gnomon::client {

class ArrivalReport {
 public:
  static constexpr Nanoseconds kInterval = std::chrono::milliseconds(10);
  static constexpr uint32_t kMany = 64;  // so many new arrivals do not wait for the interval

  void received(uint64_t sequence, TimePoint at);

  // When the next report is due; TimePoint::max() if nothing has arrived since the last.
  TimePoint due_at() const;

  // The next report, sent at `now`. The caller fills in `recovered` and `incomplete`.
  protocol::Feedback take(TimePoint now);

 private:
  std::deque<TimePoint> arrivals_;  // of sequence numbers first_, first_ + 1 ...; {}: has not arrived
  uint64_t first_ = 1;
  std::array<uint64_t, 2> begins_{1, 1};  // first new sequence number of the last two reports, the older first
  uint64_t reported_ = 0;                 // highest sequence number reported
  uint32_t fresh_ = 0;                    // arrivals not reported yet
  TimePoint oldest_fresh_ = TimePoint::max();
  TimePoint last_report_{};
};

}  // namespace gnomon::client
