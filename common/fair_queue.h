// Whose work is done next, and who still waits. Pure: no thread, no lock, no clock.
//
// Every owner has a queue of its own; they take turns at a fixed number of places. One that has w places gets another one
// only while more than w are free, so that one that asks for many slow things leaves places to the others (Choudhury and
// Hahne, "Dynamic Queue Length Thresholds for Shared-Memory Packet Switches", 1998, with alpha = 1: of n free places one
// owner takes half).
#pragma once

#include <cstdint>
#include <deque>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

namespace gnomon {

template <class Owner, class Request>
class FairQueue {
 public:
  explicit FairQueue(uint32_t places) : free_(places) {}
  // `unlimited`: one that may take every place.
  FairQueue(uint32_t places, Owner unlimited) : free_(places), unlimited_(std::in_place, std::move(unlimited)) {}

  void push(const Owner& owner, Request request) { lanes_[owner].waiting.push_back(std::move(request)); }

  // The next request, which has a place until done() is called for its owner. nullopt if nobody waits who may have a
  // place now. Allocates nothing.
  std::optional<Request> start() {
    const auto turn = next_turn();
    if (turn == lanes_.end()) return std::nullopt;
    Lane& lane = turn->second;
    ++lane.at_work;
    --free_;
    last_.emplace(turn->first);
    std::optional<Request> request(std::move(lane.waiting.front()));
    lane.waiting.pop_front();
    return request;
  }

  void done(const Owner& owner) {
    ++free_;
    const auto lane = lanes_.find(owner);
    --lane->second.at_work;
    drop_if_unused(lane);
  }

  // Drops the waiting requests for which `matches` returns true.
  template <class Matches>
  void drop(Matches matches) {
    for (auto lane = lanes_.begin(); lane != lanes_.end();) {
      std::erase_if(lane->second.waiting, matches);
      lane = drop_if_unused(lane);
    }
  }

 private:
  struct Lane {
    std::deque<Request> waiting;
    uint32_t at_work = 0;
  };
  using Lanes = std::map<Owner, Lane>;

  typename Lanes::iterator drop_if_unused(typename Lanes::iterator lane) {
    return lane->second.waiting.empty() && lane->second.at_work == 0 ? lanes_.erase(lane) : std::next(lane);
  }

  bool may_start(const typename Lanes::value_type& entry) const {
    const auto& [owner, lane] = entry;
    return !lane.waiting.empty() && free_ > (unlimited_ && *unlimited_ == owner ? 0 : lane.at_work);
  }

  // The first owner after the last one, in a circle, who may have a place.
  typename Lanes::iterator next_turn() {
    const auto after = last_ ? lanes_.upper_bound(*last_) : lanes_.begin();
    for (auto turn = after; turn != lanes_.end(); ++turn) {
      if (may_start(*turn)) return turn;
    }
    for (auto turn = lanes_.begin(); turn != after; ++turn) {
      if (may_start(*turn)) return turn;
    }
    return lanes_.end();
  }

  uint32_t free_;
  std::optional<Owner> unlimited_, last_;  // last_: whose turn it was
  Lanes lanes_;
};

}  // namespace gnomon
