// A rate limit that allows a burst after a pause: the Generic Cell Rate Algorithm (ITU-T I.371) in its virtual
// scheduling form.
#pragma once

#include <algorithm>

#include "common/clock.h"

namespace gnomon::scheduler {

class RateLimit {
 public:
  // `per_second`: amount in the long run; 0: no limit. `burst`: how much unused time is saved up at most.
  explicit RateLimit(double per_second = 0, Nanoseconds burst = {}) : per_second_(per_second), burst_(burst) {}

  bool limits() const { return per_second_ > 0; }

  // The time from which something may be spent; not in the future if it may be spent now.
  TimePoint eligible_at() const { return limits() ? next_ - burst_ : TimePoint::min(); }

  void spend(double amount, TimePoint now) {
    if (!limits()) return;
    const std::chrono::duration<double> takes(amount / per_second_);
    next_ = std::max(next_, now) + std::chrono::duration_cast<Nanoseconds>(takes);
  }

  // Changes the rate; what was spent before stays counted at the old rate.
  void set(double per_second) { per_second_ = per_second; }

 private:
  double per_second_ = 0;
  Nanoseconds burst_{};
  TimePoint next_{};
};

}  // namespace gnomon::scheduler
