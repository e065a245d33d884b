#include "client/load/load_figures.h"

#include <algorithm>

namespace gnomon::client {

StageTimes& StageTimes::operator+=(const StageTimes& other) {
  answers += other.answers;
  response += other.response;
  server += other.server;
  device += other.device;
  known += other.known;
  queue += other.queue;
  return *this;
}

void StageTimes::take_queue(const StageTimes& before, Nanoseconds mean) {
  const Nanoseconds waited = (server - device) - (before.server - before.device);
  // The server's second holds answers that are not here yet, and some of before.
  known += waited;
  queue += std::min(waited, mean * static_cast<int64_t>(answers - before.answers));
}

double StageTimes::queue_ms() const {
  return knows_queue() ? mean_ms(server - device, answers) * (to_seconds(queue) / to_seconds(known)) : 0;
}

double StageTimes::encode_ms() const { return mean_ms(server - device, answers) - queue_ms(); }

double StageTimes::mean_ms(Nanoseconds sum, uint64_t count) {
  return count > 0 ? to_milliseconds(sum) / static_cast<double>(count) : 0;
}

LoadFigures& LoadFigures::operator+=(const LoadFigures& other) {
  counters += other.counters;
  pending += other.pending;
  frames_in_time += other.frames_in_time;
  latencies.add(other.latencies);
  times += other.times;
  reopened += other.reopened;
  longest_gap = std::max(longest_gap, other.longest_gap);
  bytes += other.bytes;
  return *this;
}

uint64_t LoadFigures::coalesced() const {
  const uint64_t settled = answered() + dropped();
  return offered() > settled ? offered() - settled : 0;
}

double LoadFigures::bytes_per_frame() const {
  return answered() > 0 ? static_cast<double>(bytes) / static_cast<double>(answered()) : 0;
}

}  // namespace gnomon::client
