// How dear the bits of a scene can be: what bounds a job whose view may be dearer than those of late.
//
// A line through the costs of late (CostModel) says what a job will probably cost. Whoever shows the sky for some frames
// makes it say that a frame costs nothing; here such frames count for nothing. Only jobs of some length tell, and the
// second dearest of them counts, so that one job which a busy machine delayed does not.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <utility>

#include "common/clock.h"

namespace gnomon::scheduler {

class WorstRate {
 public:
  // A job of so many bits, traced in `trace`. `telling`: the length from which a job counts.
  void learn(uint64_t bits, Nanoseconds trace, Nanoseconds telling) {
    spent_ += trace;
    if (spent_ > kRemembered) {
      spent_ = {};
      before_ = std::exchange(dearest_, {});
    }
    if (bits == 0 || trace < telling) return;
    const double rate = static_cast<double>(trace.count()) / static_cast<double>(bits);
    if (rate <= dearest_[1]) return;
    dearest_[1] = rate;
    std::sort(dearest_.begin(), dearest_.end(), std::greater<>());
  }

  // So many bits take no longer than `limit`, as far as one knows, and are no more than `most`.
  uint64_t bits_within(Nanoseconds limit, uint64_t most) const {
    // The second of all four.
    const double worst = std::max(std::min(dearest_[0], before_[0]), std::max(dearest_[1], before_[1]));  // ns
    if (worst <= 0) return most;
    return static_cast<uint64_t>(std::min(static_cast<double>(most), static_cast<double>(limit.count()) / worst));
  }

  // Device time that the scene's jobs take until a rate is forgotten, and at most twice that. Views that cost nothing do
  // not make time pass.
  static constexpr Nanoseconds kRemembered = std::chrono::minutes(10);

 private:
  std::array<double, 2> dearest_{}, before_{};  // ns a bit, the dearest first; since spent_ was 0, and before that
  Nanoseconds spent_{};
};

}  // namespace gnomon::scheduler
