// Whether every render thread is alive, from their heartbeats. Pure: the caller has the clock. One thread.
#pragma once

#include <algorithm>
#include <vector>

#include "daemon/service/heartbeat.h"

namespace gnomon::daemon {

class Liveness {
 public:
  // The heartbeats outlive this.
  explicit Liveness(std::vector<Heartbeat*> heartbeats)
      : heartbeats_(std::move(heartbeats)), beaten_(heartbeats_.size()) {}

  // True if every heartbeat has beaten since the last time that this was true. Idle threads beat at different moments,
  // so that a beat counts until all the others have beaten too.
  bool check(TimePoint now) {
    for (size_t i = 0; i < heartbeats_.size(); ++i) beaten_[i] = heartbeats_[i]->lives(now) || beaten_[i];
    if (std::find(beaten_.begin(), beaten_.end(), false) != beaten_.end()) return false;
    beaten_.assign(beaten_.size(), false);
    return true;
  }

 private:
  std::vector<Heartbeat*> heartbeats_;
  std::vector<bool> beaten_;  // of each, since check() was last true
};

}  // namespace gnomon::daemon
