// Which half-open connection loses its place when there are too many: the oldest of the network that has most of them. A
// network that opens many pushes out its own, whatever it does; a client of another network keeps its place.
//
// Only connections that exist are counted, so that nothing has to be remembered or forgotten. Pure: no thread, no clock.
#pragma once

#include <algorithm>
#include <cstddef>
#include <list>
#include <map>
#include <optional>

#include "daemon/session/client_network.h"

namespace gnomon::daemon {

// `Holder`: what stands for a connection, comparable and cheap to copy.
template <class Holder>
class HalfOpenPlaces {
 public:
  explicit HalfOpenPlaces(size_t most) : most_(most) {}

  // Returns who loses its place for it, who has none any more; nullopt if there was room. Precondition: the holder has no
  // place.
  std::optional<Holder> take(Holder holder, const ClientNetwork& network) {
    taken_.push_back({holder, network});
    ++of_network_[network];
    if (taken_.size() <= most_) return std::nullopt;
    const auto loser = std::find_if(taken_.begin(), taken_.end(), [&, many = largest()](const Taken& taken) {
      return of_network_.at(taken.network) == many;
    });
    const Holder out = loser->holder;
    erase(loser);
    return out;
  }

  // Returns false if the holder had no place.
  bool give_back(const Holder& holder) {
    const auto found =
        std::find_if(taken_.begin(), taken_.end(), [&](const Taken& taken) { return taken.holder == holder; });
    if (found == taken_.end()) return false;
    erase(found);
    return true;
  }

  size_t taken() const { return taken_.size(); }

 private:
  struct Taken {
    Holder holder;
    ClientNetwork network;
  };

  size_t largest() const {
    return std::max_element(of_network_.begin(), of_network_.end(),
                            [](const auto& a, const auto& b) { return a.second < b.second; })
        ->second;
  }

  void erase(typename std::list<Taken>::iterator at) {
    const auto network = of_network_.find(at->network);
    if (--network->second == 0) of_network_.erase(network);
    taken_.erase(at);
  }

  size_t most_;
  std::list<Taken> taken_;  // oldest first
  std::map<ClientNetwork, size_t> of_network_;
};

}  // namespace gnomon::daemon
