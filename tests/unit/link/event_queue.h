// Virtual time: events run in the order of their times, without waiting, and always in the same order.
#pragma once

#include <functional>
#include <map>

#include "common/clock.h"

namespace gnomon::tests {

class EventQueue {
 public:
  TimePoint now() const { return now_; }
  void at(TimePoint when, std::function<void()> call) { events_.emplace(std::max(when, now_), std::move(call)); }

  void run_until(TimePoint end) {
    while (!events_.empty() && events_.begin()->first <= end) {
      now_ = events_.begin()->first;
      const auto call = std::move(events_.begin()->second);
      events_.erase(events_.begin());
      call();
    }
    now_ = end;
  }

 private:
  TimePoint now_{std::chrono::seconds(1)};  // not TimePoint{}, which some code uses for "never"
  std::multimap<TimePoint, std::function<void()>> events_;
};

}  // namespace gnomon::tests
