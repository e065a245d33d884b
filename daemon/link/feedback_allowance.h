// How many Feedbacks a client may send: each of them costs the server time. Pure.
//
// A client sends one 10 ms after the last, and one as soon as 64 datagrams have arrived since. So the allowance grows
// with time and with what was sent, both at twice the rate that an honest client needs; the rest covers reports that a
// path has held back and delivers together.
#pragma once

#include <algorithm>

#include "common/clock.h"

namespace gnomon::daemon {

class FeedbackAllowance {
 public:
  static constexpr double kPerSecond = 200;
  static constexpr double kPerDatagram = 1.0 / 32;
  static constexpr double kMost = 256;  // unused ones that are kept

  void sent() { left_ = std::min(kMost, left_ + kPerDatagram); }

  // False if the client has used up its allowance. `now` does not decrease.
  bool take(TimePoint now) {
    left_ = std::min(kMost, left_ + kPerSecond * to_seconds(now - refilled_));
    refilled_ = now;
    if (left_ < 1) return false;
    left_ -= 1;
    return true;
  }

 private:
  double left_ = kMost;
  TimePoint refilled_{};
};

}  // namespace gnomon::daemon
