// Rate-limits log lines: a token bucket for each event, and a count of the lines that were suppressed.
//
// The caller serialises all calls and passes the time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "common/clock.h"

namespace gnomon::log {

class LogRateLimiter {
 public:
  LogRateLimiter(double burst, double per_second) : burst_(burst), per_second_(per_second) {}

  // Returns how many lines of this event were suppressed since the last admitted one; nullopt if this line is to be
  // suppressed too.
  std::optional<uint64_t> admit(std::string_view event, TimePoint now) {
    auto found = events_.find(event);
    if (found == events_.end()) {
      // Events are string literals of the program, so the map has a bounded size.
      found = events_.emplace(std::string(event), Event{burst_, now, 0}).first;
    }
    Event& known = found->second;
    known.tokens = std::min(burst_, known.tokens + per_second_ * to_seconds(now - known.since));
    known.since = now;
    if (known.tokens < 1) {
      ++known.left_out;
      return std::nullopt;
    }
    known.tokens -= 1;
    return std::exchange(known.left_out, 0);
  }

 private:
  struct Event {
    double tokens;
    TimePoint since;
    uint64_t left_out;
  };

  double burst_, per_second_;
  std::map<std::string, Event, std::less<>> events_;
};

}  // namespace gnomon::log
