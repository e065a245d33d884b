// How much forward error correction (parity) a frame gets. Pure.
#pragma once

#include <cmath>
#include <cstddef>

#include "protocol/parity.h"

namespace gnomon::daemon {

inline constexpr double kLeastLoss = 0.005;     // share of datagrams; below it parity costs more than it saves
inline constexpr double kGroupFailure = 0.005;  // accepted probability that a group cannot be rebuilt
inline constexpr size_t kGroupSlices = 32;      // most slices of a group

// The fewest parity shards with which a group of `slices` can be rebuilt with probability 1 - kGroupFailure, if each
// datagram, parity included, is lost independently with probability `loss`. At most half of the slices, at least one.
inline size_t parity_count(size_t slices, double loss) {
  const size_t most = std::max<size_t>(1, slices / 2);
  for (size_t parity = 1; parity < most; ++parity) {
    // P(at most `parity` of slices + parity datagrams are lost): the binomial distribution, summed up.
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
