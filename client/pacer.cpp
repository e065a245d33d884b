#include "client/pacer.h"

#include <algorithm>

namespace gnomon::client {

TimePoint Pacer::next_send(size_t in_flight) const {
  const bool window_full = options_.max_in_flight > 0 && in_flight >= options_.max_in_flight;
  return window_full ? std::max(next_by_rate_, last_sent_ + options_.retry) : next_by_rate_;
}

void Pacer::sent(TimePoint now) {
  last_sent_ = now;
  if (options_.rate_hz <= 0) return;
  const auto interval =
      std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(1.0 / options_.rate_hz));
  // A steady rhythm; after a pause it goes on from now, without making up for what was missed.
  next_by_rate_ = std::max(next_by_rate_ + interval, now);
}

}  // namespace gnomon::client
