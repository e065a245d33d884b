// Response times and their percentiles.
#pragma once

#include <vector>

#include "common/clock.h"

namespace gnomon::client {

class Latencies {
 public:
  void add(Nanoseconds sample);
  void add(const Latencies& others);

  size_t count() const { return samples_.size(); }
  // The smallest sample that at least `share` of all do not exceed (0: the least, 1: the greatest). Without
  // samples: zero.
  Nanoseconds percentile(double share) const;

 private:
  mutable std::vector<Nanoseconds> samples_;  // sorted when asked
  mutable bool sorted_ = true;
};

}  // namespace gnomon::client
