// How much smaller a session's picture is than granted because the device has no memory for its frames: half the pixels
// less at each refusal, and a try with twice as many after a while. Whatever its tenant's terms: the alternative is no
// picture. Pure.
#pragma once

#include <cmath>
#include <cstdint>

#include "common/clock.h"

namespace gnomon::daemon {

class MemorySteps {
 public:
  // A frame of this size was refused. False: there is nothing smaller to try.
  bool refuse(TimePoint now) {
    next_try_ = now + kPatience;
    if (level_ == kDeepest) return false;
    ++level_;
    return true;
  }

  // True: larger frames may be tried again, from now on.
  bool recover(TimePoint now) {
    if (level_ == 0 || now < next_try_) return false;
    --level_;
    next_try_ = now + kPatience;
    return true;
  }

  double size() const { return std::exp2(-0.5 * level_); }  // of each side

 private:
  static constexpr std::chrono::seconds kPatience{2};
  static constexpr uint32_t kDeepest = 16;  // 1/256 of each side: a tile, of the largest frames

  uint32_t level_ = 0;
  TimePoint next_try_{};
};

}  // namespace gnomon::daemon
