// At most so much a second, in the long run; a little more at once after a pause.
#pragma once

#include <algorithm>

#include "common/clock.h"

namespace gnomon::scheduler {

class RateLimit {
 public:
  // `per_second` 0: no limit. What was not used within `burst` is not saved up.
  explicit RateLimit(double per_second = 0, Nanoseconds burst = {}) : per_second_(per_second), burst_(burst) {}

  bool limits() const { return per_second_ > 0; }

  // From when on something may be spent, in the past if now.
  TimePoint open_at() const { return limits() ? next_ - burst_ : TimePoint::min(); }

  void spend(double amount, TimePoint now) {
    if (!limits()) return;
    const std::chrono::duration<double> takes(amount / per_second_);
    next_ = std::max(next_, now) + std::chrono::duration_cast<Nanoseconds>(takes);
  }

  // The same limit from now on at another rate.
  void set(double per_second) { per_second_ = per_second; }

 private:
  double per_second_ = 0;
  Nanoseconds burst_{};
  TimePoint next_{};
};

}  // namespace gnomon::scheduler
