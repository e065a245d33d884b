// Requests for scenes that a loader has taken and that wait in no reading yet: who gives one up meanwhile is found here.
// Pure: no thread, no lock.
#pragma once

#include <algorithm>
#include <vector>

#include "common/ids.h"

namespace gnomon::daemon {

// A request of SceneHost::fetch().
using FetchId = StrongId<struct FetchTag, uint64_t>;

class RequestsInHand {
 public:
  // `most`: at a time.
  explicit RequestsInHand(size_t most) { taken_.reserve(most); }

  void take(FetchId id) { taken_.push_back({id}); }  // allocates nothing
  void give_up(FetchId id) {
    for (Taken& each : taken_) each.given_up |= each.id == id;
  }
  // It is no longer in hand. Returns whether it was given up. Precondition: it was taken.
  bool put_down(FetchId id) {
    const auto found = std::find_if(taken_.begin(), taken_.end(), [&](const Taken& each) { return each.id == id; });
    const bool given_up = found->given_up;
    taken_.erase(found);
    return given_up;
  }

 private:
  struct Taken {
    FetchId id;
    bool given_up = false;
  };
  std::vector<Taken> taken_;
};

}  // namespace gnomon::daemon
