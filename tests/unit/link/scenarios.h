// The link conditions that Gnomon's protocol promises to cope with, in virtual time: the same figures for the same
// seed, on any machine. Tests check them against the promise, gnomon-bench transport reports them.
#pragma once

#include <cstdint>
#include <vector>

#include "common/clock.h"

namespace gnomon::tests {

struct LossFigures {
  double fresh_share = 0;      // of tiles that are of this frame or a newer one, one further frame later
  Nanoseconds longest_gap{};   // between two frames' looks
  Nanoseconds recovery{};      // from the end of heavy losses until all tiles are fresh and stay so for a second
  uint64_t retransmitted = 0;  // datagrams
  uint64_t recovered = 0;      // slices rebuilt from parity
};

// 5% of the datagrams of both directions lost for 20 s, on a path of `delay` each way.
LossFigures random_loss(uint64_t seed, Nanoseconds delay);
// Bursts of losses of 5 datagrams, 2.5% in all.
LossFigures bursty_loss(uint64_t seed);
// 30% lost for 5 s, then none.
LossFigures heavy_loss(uint64_t seed);

struct QueueFigures {
  Nanoseconds wait_p95{};  // of datagrams before the bottleneck
  Nanoseconds wait_max{};
  double used_share = 0;  // of the bottleneck's rate
};

// A bottleneck of 10 Mbit/s, and a session that would like 16. Of the 30 s after its first second; `start`: of
// its first second, and the share used in the one after.
QueueFigures bottleneck(uint64_t seed, bool start = false, Nanoseconds delay = std::chrono::milliseconds(25));

struct Shares {
  std::vector<double> sessions;  // of what all together got
  double tcp = 0;
  Nanoseconds wait_p95{};  // of the sessions' datagrams
};

// Sessions that come one after the other, and if so a greedy TCP flow, at a bottleneck of 20 Mbit/s with a queue of
// 100 ms.
Shares sharing(uint64_t seed, uint32_t sessions, bool tcp);

struct MtuFigures {
  size_t found = 0;           // payload of the longest datagrams, once the path's MTU had been looked for
  size_t after = 0;           // and in the end
  Nanoseconds longest_gap{};  // between two whole looks, from the path's change on
  double fresh_share = 0;     // in the last seconds
};

// A path that takes Ethernet's datagrams for 5 s, and then only those of 1,300 bytes, without a word.
MtuFigures narrowing_path(uint64_t seed);

}  // namespace gnomon::tests
