// The time at which each session has to be served next. Belongs to the net thread.
#pragma once

#include <set>
#include <unordered_map>
#include <utility>

#include "common/clock.h"
#include "common/ids.h"

namespace gnomon::daemon {

class TimerQueue {
 public:
  // Replaces the session's earlier time; TimePoint::max() removes it.
  void set(SessionId id, TimePoint when) {
    const auto found = times_.find(id);
    if (found != times_.end() && found->second == when) return;
    remove(id);
    if (when == TimePoint::max()) return;
    times_.emplace(id, when);
    order_.emplace(when, id);
  }

  void remove(SessionId id) {
    const auto found = times_.find(id);
    if (found == times_.end()) return;
    order_.erase({found->second, id});
    times_.erase(found);
  }

  // The earliest time; TimePoint::max() if there is none.
  TimePoint next() const { return order_.empty() ? TimePoint::max() : order_.begin()->first; }

  // Removes a session whose time has come and stores its id in `id`; returns false if there is none.
  bool take(TimePoint now, SessionId& id) {
    if (next() > now) return false;
    id = order_.begin()->second;
    remove(id);
    return true;
  }

 private:
  std::unordered_map<SessionId, TimePoint> times_;
  std::set<std::pair<TimePoint, SessionId>> order_;
};

}  // namespace gnomon::daemon
