// Whose scene is read next. Pure: no thread, no lock, no clock.
//
// Every tenant has a queue of its own and the daemon's operator another one; they take turns, so that a tenant that asks
// for many scenes, or for slow ones, delays its own first.
#pragma once

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
  void push(SceneAsker asker, Request request) { queues_[asker].push_back(std::move(request)); }

  bool empty() const { return queues_.empty(); }

  // Precondition: !empty().
  Request pop() {
    auto turn = queues_.upper_bound(last_);
    if (turn == queues_.end()) turn = queues_.begin();
    last_ = turn->first;
    Request request = std::move(turn->second.front());
    turn->second.pop_front();
    if (turn->second.empty()) queues_.erase(turn);
    return request;
  }

 private:
  std::map<SceneAsker, std::deque<Request>> queues_;  // none is empty
  SceneAsker last_;                                   // whose turn it was
};

}  // namespace gnomon::daemon
