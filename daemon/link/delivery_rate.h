// How fast datagrams arrive at the client, over the last 100 ms of its clock. Pure. An arrival costs constant time on
// average, whatever the client's clock does.
#pragma once

#include <algorithm>
#include <deque>

#include "common/clock.h"

namespace gnomon::daemon {

class DeliveryRate {
 public:
  // `at`: on the client's clock, up to a constant (client_clock.h bounds it).
  void arrived(TimePoint at, size_t bytes) {
    if (!arrivals_.empty() && at < arrivals_.back().at) {
      // Datagrams overtake each other by little. A clock that was set back by more says nothing of earlier arrivals.
      if (arrivals_.back().at - at > kWindow)
        forget();
      else
        at = arrivals_.back().at;
    }
    arrivals_.push_back({at, bytes});
    bytes_ += bytes;
    while (arrivals_.back().at - arrivals_.front().at > kWindow || arrivals_.size() > kMostArrivals) {
      bytes_ -= arrivals_.front().bytes;
      arrivals_.pop_front();
    }
  }

  // 0 before anything has arrived.
  double bytes_per_second() const {
    if (arrivals_.empty()) return 0;
    const Nanoseconds span = arrivals_.back().at - arrivals_.front().at;
    return static_cast<double>(bytes_) / to_seconds(std::max<Nanoseconds>(span, kShortestSpan));
  }

  size_t remembered() const { return arrivals_.size(); }

 private:
  static constexpr Nanoseconds kWindow = std::chrono::milliseconds(100);
  static constexpr Nanoseconds kShortestSpan = std::chrono::milliseconds(10);
  // LossDetection remembers no more datagrams. A client's clock that stands still would otherwise keep every datagram of
  // the session in the window.
  static constexpr size_t kMostArrivals = 1 << 14;

  struct Delivered {
    TimePoint at;
    size_t bytes;
  };

  void forget() {
    arrivals_.clear();
    bytes_ = 0;
  }

  std::deque<Delivered> arrivals_;
  size_t bytes_ = 0;  // of arrivals_
};

}  // namespace gnomon::daemon
