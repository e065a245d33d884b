// State that all policies keep: the sessions, numbered densely so that IndexedHeap can hold them, and the device time
// that tenants were charged.
#pragma once

#include <algorithm>
#include <cassert>
#include <optional>
#include <unordered_map>
#include <vector>

#include "scheduler/scheduler.h"

namespace gnomon::scheduler {

// A policy's state for each session. The numbers of removed sessions are reused.
template <class State>
class SessionStates {
 public:
  uint32_t add(SessionId session, const State& state) {
    assert(!numbers_.contains(session));
    uint32_t number = static_cast<uint32_t>(states_.size());
    if (unused_.empty()) {
      states_.push_back(state);
      unused_.reserve(states_.capacity());
    } else {
      number = unused_.back();
      unused_.pop_back();
      states_[number] = state;
    }
    numbers_.emplace(session, number);
    return number;
  }

  void remove(SessionId session) {
    const auto found = numbers_.find(session);
    unused_.push_back(found->second);
    numbers_.erase(found);
  }

  // The session's number; nullopt if there is no such session.
  std::optional<uint32_t> find(SessionId session) const {
    const auto found = numbers_.find(session);
    return found == numbers_.end() ? std::nullopt : std::optional(found->second);
  }

  State& operator[](uint32_t number) { return states_[number]; }
  size_t capacity() const { return states_.size(); }

 private:
  std::unordered_map<SessionId, uint32_t> numbers_;
  std::vector<State> states_;
  std::vector<uint32_t> unused_;
};

// The device time that each tenant was charged.
class Services {
 public:
  void know(TenantId tenant) {
    if (services_.size() <= tenant.value) services_.resize(tenant.value + 1);
  }
  void charge(TenantId tenant, Nanoseconds cost) { services_[tenant.value] += cost; }
  Nanoseconds of(TenantId tenant) const {
    return tenant.value < services_.size() ? services_[tenant.value] : Nanoseconds{};
  }

 private:
  std::vector<Nanoseconds> services_;
};

inline Nanoseconds charged_cost(const Request& request) { return std::max(request.cost, Nanoseconds(1)); }

}  // namespace gnomon::scheduler
