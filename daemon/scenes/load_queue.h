// Whose scene is read next, and who still waits for one. Pure: no thread, no lock, no clock.
//
// Every tenant has a queue of its own and the daemon's operator another one; they take turns at a fixed number of
// readers. A tenant that has w readers at work gets another one only while more than w are free, so that one that asks
// for many slow scenes leaves readers to the others (Choudhury and Hahne, "Dynamic Queue Length Thresholds for
// Shared-Memory Packet Switches", 1998, with alpha = 1: of n free readers one tenant takes half). The operator's scenes
// may take every reader.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>

#include "common/ids.h"

namespace gnomon::daemon {

// nullopt: the operator.
using SceneAsker = std::optional<TenantId>;

template <class Request>
class LoadQueue {
 public:
  explicit LoadQueue(uint32_t readers) : free_(readers) {}

  void push(SceneAsker asker, Request request) { queues_[asker].push_back(std::move(request)); }

  // The next request, for which a reader is at work until done() is called for its asker. nullopt if nobody waits who
  // may have a reader now.
  std::optional<Request> start() {
    const auto turn = next_turn();
    if (turn == queues_.end()) return std::nullopt;
    uint32_t& at_work = at_work_[turn->first];  // first, as memory may be short
    ++at_work;
    --free_;
    last_ = turn->first;
    Request request = std::move(turn->second.front());
    turn->second.pop_front();
    if (turn->second.empty()) queues_.erase(turn);
    return request;
  }

  void done(SceneAsker asker) {
    ++free_;
    const auto found = at_work_.find(asker);
    if (--found->second == 0) at_work_.erase(found);
  }

  // Drops the waiting requests for which `matches` returns true.
  template <class Matches>
  void drop(Matches matches) {
    for (auto queue = queues_.begin(); queue != queues_.end();) {
      std::erase_if(queue->second, matches);
      queue = queue->second.empty() ? queues_.erase(queue) : std::next(queue);
    }
  }

 private:
  using Queues = std::map<SceneAsker, std::deque<Request>>;

  bool may_start(SceneAsker asker) const {
    const auto found = at_work_.find(asker);
    return free_ > (asker && found != at_work_.end() ? found->second : 0);
  }

  // The first asker after the last one, in a circle, who may have a reader.
  typename Queues::iterator next_turn() {
    const auto after = queues_.upper_bound(last_);
    for (auto turn = after; turn != queues_.end(); ++turn) {
      if (may_start(turn->first)) return turn;
    }
    for (auto turn = queues_.begin(); turn != after; ++turn) {
      if (may_start(turn->first)) return turn;
    }
    return queues_.end();
  }

  uint32_t free_;
  Queues queues_;                           // none is empty
  std::map<SceneAsker, uint32_t> at_work_;  // readers; none is 0
  SceneAsker last_;                         // whose turn it was
};

}  // namespace gnomon::daemon
