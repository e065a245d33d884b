#include "client/cli/camera_pacer.h"

#include <algorithm>

namespace gnomon::client {
namespace {

using namespace std::chrono_literals;

constexpr Nanoseconds kFirstPatience = 10s;  // before anything is known of the server
constexpr Nanoseconds kLeastPatience = 1s;

}  // namespace

TimePoint CameraPacer::next_send(size_t in_flight) const {
  const bool window_full = options_.max_in_flight > 0 && in_flight >= options_.max_in_flight;
  return window_full ? std::max(next_by_rate_, last_sent_ + answer_patience()) : next_by_rate_;
}

void CameraPacer::sent(TimePoint now) {
  last_sent_ = now;
  if (options_.rate_hz <= 0) return;
  const auto interval =
      std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(1.0 / options_.rate_hz));
  // A steady rhythm; after a pause it continues from now, without catching up.
  next_by_rate_ = std::max(next_by_rate_ + interval, now);
}

void CameraPacer::answered(Nanoseconds response) {
  if (!any_answer_) {
    any_answer_ = true;
    mean_response_ = response;
    mean_deviation_ = response / 2;
    return;
  }
  mean_deviation_ = (3 * mean_deviation_ + std::chrono::abs(mean_response_ - response)) / 4;
  mean_response_ = (7 * mean_response_ + response) / 8;
}

Nanoseconds CameraPacer::answer_patience() const {
  return any_answer_ ? std::max(kLeastPatience, mean_response_ + 4 * mean_deviation_) : kFirstPatience;
}

}  // namespace gnomon::client
