#include "client/cli/latency.h"

#include <algorithm>
#include <cmath>

namespace gnomon::client {

void Latencies::add(Nanoseconds sample) {
  samples_.push_back(sample);
  sorted_ = false;
}

void Latencies::add(const Latencies& others) {
  samples_.insert(samples_.end(), others.samples_.begin(), others.samples_.end());
  sorted_ = false;
}

Nanoseconds Latencies::percentile(double share) const {
  if (samples_.empty()) return {};
  if (!sorted_) std::sort(samples_.begin(), samples_.end());
  sorted_ = true;
  const auto rank = static_cast<size_t>(std::ceil(share * static_cast<double>(samples_.size())));
  return samples_[std::clamp<size_t>(rank, 1, samples_.size()) - 1];
}

}  // namespace gnomon::client
