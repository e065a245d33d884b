// How much parity a frame gets. Pure.
#pragma once

#include <cmath>
#include <cstddef>

#include "protocol/parity.h"

namespace gnomon::daemon {

inline constexpr double kLeastLoss = 0.005;     // of datagrams; below, parity costs more than it saves
inline constexpr double kGroupFailure = 0.005;  // a group that cannot be rebuilt is no more likely than this
inline constexpr size_t kGroupSlices = 32;

// The fewest shards for `slices` of which each datagram is lost with probability `loss`, parity itself included.
// Never more than half of the slices, and one at least.
inline size_t parity_count(size_t slices, double loss) {
  const size_t most = std::max<size_t>(1, slices / 2);
  for (size_t parity = 1; parity < most; ++parity) {
    // P(no more than `parity` of slices + parity are lost), the binomial distribution summed up.
    const double sent = static_cast<double>(slices + parity);
    double term = std::pow(1 - loss, sent), good = term;
    for (size_t lost = 1; lost <= parity; ++lost) {
      term *= (sent - static_cast<double>(lost) + 1) / static_cast<double>(lost) * loss / (1 - loss);
      good += term;
    }
    if (1 - good <= kGroupFailure) return parity;
  }
  return most;
}

inline size_t parity_groups(size_t slices) { return (slices + kGroupSlices - 1) / kGroupSlices; }

}  // namespace gnomon::daemon
