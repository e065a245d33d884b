// A model of a greedy TCP sender that affects other flows on a link as a real one does: slow start, additive increase,
// CUBIC's factor on loss (RFC 5681 with RFC 9438's 0.7), at most one cut in a round trip. Virtual time.
#pragma once

#include <cmath>
#include <map>

#include "tests/tools/netsim/link.h"
#include "tests/unit/link/event_queue.h"

namespace gnomon::tests {

class TcpFlow {
 public:
  TcpFlow(EventQueue& events, netsim::Link& data, netsim::Link& acks, TimePoint start)
      : events_(events), data_(data), acks_(acks) {
    events_.at(start, [this] { fill(); });
  }

  uint64_t delivered_bytes() const { return delivered_; }

 private:
  static constexpr size_t kSegment = 1500;
  static constexpr Nanoseconds kTimeout = std::chrono::seconds(1);

  void fill() {
    while (static_cast<double>(flying_.size()) < window_) send();
  }

  void send() {
    const uint64_t number = next_++;
    flying_.emplace(number, events_.now());
    const auto fate = data_.send(kSegment, events_.now());
    if (fate.copies > 0) events_.at(fate.at[0], [this, number] { arrive(number); });
    events_.at(events_.now() + kTimeout, [this, number] { time_out(number); });
  }

  void arrive(uint64_t number) {
    delivered_ += kSegment;
    const auto fate = acks_.send(40, events_.now());
    if (fate.copies > 0) events_.at(fate.at[0], [this, number] { acknowledge(number); });
  }

  void acknowledge(uint64_t number) {
    const auto found = flying_.find(number);
    if (found == flying_.end()) return;
    flying_.erase(found);
    window_ += window_ < threshold_ ? 1 : 1 / window_;
    while (!flying_.empty() && flying_.begin()->first + 3 <= number) {
      cut(flying_.begin()->first, 0.7);
      flying_.erase(flying_.begin());
    }
    fill();
  }

  void time_out(uint64_t number) {
    if (!flying_.contains(number)) return;
    cut(number, 0.1);
    flying_.clear();
    fill();
  }

  void cut(uint64_t number, double factor) {
    if (number < recover_) return;  // the rate was cut in this round trip already
    window_ = std::max(2.0, window_ * factor);
    threshold_ = window_;
    recover_ = next_;
  }

  EventQueue& events_;
  netsim::Link& data_;
  netsim::Link& acks_;
  std::map<uint64_t, TimePoint> flying_;
  uint64_t next_ = 0, recover_ = 0;
  double window_ = 10, threshold_ = 1e9;
  uint64_t delivered_ = 0;
};

}  // namespace gnomon::tests
