// How much smaller a session's frames are than granted because the device has no memory for them: each refusal halves
// the number of pixels, and after a while twice as many are tried again. The tenant's limits do not apply, as the
// alternative is to render nothing. Pure.
#pragma once

#include <cmath>
#include <cstdint>

#include "common/clock.h"

namespace gnomon::daemon {

class MemorySteps {
 public:
  // A frame of this size was refused. Returns false if there is no smaller size to try.
  bool refuse(TimePoint now) {
    next_try_ = now + kPatience;
    if (level_ == kDeepest) return false;
    ++level_;
    return true;
  }

  // Returns true if larger frames are to be tried again from now on.
  bool recover(TimePoint now) {
    if (level_ == 0 || now < next_try_) return false;
    --level_;
    next_try_ = now + kPatience;
    return true;
  }

  double size() const { return std::exp2(-0.5 * level_); }  // of each side

 private:
  static constexpr std::chrono::seconds kPatience{2};
  static constexpr uint32_t kDeepest = 16;  // 1/256 of each side: one tile of the largest frames

  uint32_t level_ = 0;
  TimePoint next_try_{};
};

}  // namespace gnomon::daemon
