// The link conditions that Gnomon's protocol promises to cope with, in virtual time: the same seed gives the same
// figures on any machine. Tests check them against the promise, gnomon-bench transport reports them.
#pragma once

#include <cstdint>
#include <vector>

#include "common/clock.h"

namespace gnomon::tests {

struct LossFigures {
  double fresh_share = 0;     // of tiles that are of a frame or a newer one when the next frame should have arrived
  Nanoseconds longest_gap{};  // between two frames' looks
  Nanoseconds recovery{};     // from the end of heavy losses until all tiles are fresh and stay so for a second
  uint64_t retransmitted = 0;  // datagrams
  uint64_t recovered = 0;      // slices rebuilt from parity
};

// 5% of the datagrams of both directions are lost for 20 s, on a path with `delay` each way.
LossFigures random_loss(uint64_t seed, Nanoseconds delay);
// Datagrams are lost in bursts of 5 on average, 2.5% in all.
LossFigures bursty_loss(uint64_t seed);
// 30% of the datagrams are lost for 5 s, then none.
LossFigures heavy_loss(uint64_t seed);

struct QueueFigures {
  Nanoseconds wait_p95{};  // of datagrams in the bottleneck's queue
  Nanoseconds wait_max{};
  double used_share = 0;  // of the bottleneck's rate
};

// A session that has 16 Mbit/s to send, at a bottleneck of 10 Mbit/s. The figures are of the 30 s after its first
// second; with `start`, the waits are of its first second and the used share of the second after it.
QueueFigures bottleneck(uint64_t seed, bool start = false, Nanoseconds delay = std::chrono::milliseconds(25));

struct Shares {
  std::vector<double> sessions;  // of the rate that all flows got together
  double tcp = 0;
  Nanoseconds wait_p95{};  // of the sessions' datagrams
};

// Sessions that start one after the other, and with `tcp` a greedy TCP flow, at a bottleneck of 20 Mbit/s with a queue
// of 100 ms.
Shares sharing(uint64_t seed, uint32_t sessions, bool tcp);

struct MtuFigures {
  size_t found = 0;           // longest payload in bytes before the path changes
  size_t after = 0;           // longest payload in bytes at the end
  Nanoseconds longest_gap{};  // between two looks with complete frames, after the path's change
  double fresh_share = 0;     // in the last seconds
};

// A path that carries Ethernet's datagrams for 5 s, and then silently drops those longer than 1,300 bytes.
MtuFigures narrowing_path(uint64_t seed);

}  // namespace gnomon::tests
