// How fast datagrams arrive at the client, over the last 100 ms of its clock. Pure.
#pragma once

#include <algorithm>
#include <deque>

#include "common/clock.h"

namespace gnomon::daemon {

class DeliveryRate {
 public:
  // `at`: on the client's clock, up to a constant.
  void arrived(Nanoseconds at, size_t bytes) {
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

 private:
  static constexpr Nanoseconds kWindow = std::chrono::milliseconds(100);
  static constexpr Nanoseconds kShortestSpan = std::chrono::milliseconds(10);
  // LossDetection remembers no more datagrams. A client's clock that stands still or runs backwards would otherwise
  // keep every datagram of the session in the window.
  static constexpr size_t kMostArrivals = 1 << 14;

  struct Delivered {
    Nanoseconds at;
    size_t bytes;
  };
  std::deque<Delivered> arrivals_;
  size_t bytes_ = 0;  // of arrivals_
};

}  // namespace gnomon::daemon
