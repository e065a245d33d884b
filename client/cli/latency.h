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
  // The smallest sample that at least `share` of all samples do not exceed (0: the smallest, 1: the greatest); zero if
  // there are no samples.
  Nanoseconds percentile(double share) const;

 private:
  mutable std::vector<Nanoseconds> samples_;  // sorted when a percentile is asked for
  mutable bool sorted_ = true;
};

}  // namespace gnomon::client
