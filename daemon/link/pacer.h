// When the next datagram may be sent, so that a frame's datagrams are spread in time instead of filling a queue on the
// path.
#pragma once

#include "common/clock.h"

namespace gnomon::daemon {

class Pacer {
 public:
  // Datagrams that are due within this time may be sent together, with one wake-up and one system call.
  static constexpr Nanoseconds kBatch = std::chrono::milliseconds(1);

  bool may_send(TimePoint now) const { return now >= next_; }
  TimePoint next() const { return next_; }

  // `rate`: bytes a second, more than 0.
  void sent(size_t bytes, double rate, TimePoint now) {
    const TimePoint from = next_ < now - kBatch ? now - kBatch : next_;
    next_ = from + Nanoseconds(static_cast<int64_t>(static_cast<double>(bytes) / rate * 1e9));
  }

 private:
  TimePoint next_{};
};

}  // namespace gnomon::daemon
