// Reads the clock by which a client dates its Feedbacks. Pure.
//
// Its origin is arbitrary and its owner is not trusted: it may stand still, jump or run backwards. What is read stays
// close to our own clock whatever the client says, so that sums and differences of readings never overflow.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "common/clock.h"

namespace gnomon::daemon {

class ClientClock {
 public:
  // How far the client's clock may be from ours, counted from the first reading. Crystals drift by less than 0.01 %,
  // which is an hour in a year; a clock that is further off has jumped.
  static constexpr std::chrono::microseconds kMostOff = std::chrono::hours(1);

  // When the client's clock says `time_us`, on our clock's scale: `now` for the first reading, and for later ones what
  // the client's clock says since then, but no further than kMostOff from `now`. `now` does not decrease.
  TimePoint read(uint64_t time_us, TimePoint now) {
    if (!first_) first_ = First{time_us, now};
    const auto elapsed = static_cast<int64_t>(time_us - first_->time_us);  // modulo 2^64: the origin is arbitrary
    const int64_t ours = to_microseconds(now - first_->at);
    return first_->at +
           std::chrono::microseconds(std::clamp(elapsed, ours - kMostOff.count(), ours + kMostOff.count()));
  }

 private:
  struct First {
    uint64_t time_us = 0;
    TimePoint at{};
  };
  std::optional<First> first_;
};

}  // namespace gnomon::daemon
