#include "daemon/session/session_totals.h"

#include <utility>

namespace gnomon::daemon {
namespace {

uint32_t mean_us(Nanoseconds sum, uint32_t count) {
  return count == 0 ? 0 : static_cast<uint32_t>(to_microseconds(sum) / count);
}

}  // namespace

void SessionTotals::add(const FrameMeta& meta, TimePoint sent) {
  const FrameTimes& times = meta.times;
  ++frames_;
  coalesced_ += meta.coalesced;
  ++recent_.frames;
  recent_.queue += times.submitted - times.arrival;
  recent_.gpu += times.gpu;
  recent_.total += sent - times.arrival;
}

protocol::Stats SessionTotals::take_stats() {
  const Sums sums = std::exchange(recent_, {});
  return {frames_, coalesced_, mean_us(sums.queue, sums.frames), mean_us(sums.gpu, sums.frames),
          mean_us(sums.total, sums.frames)};
}

}  // namespace gnomon::daemon
