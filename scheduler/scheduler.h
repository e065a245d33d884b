// Which session's view is rendered next.
//
// A scheduler knows sessions and costs, no views, no GPU, no clock: time is an argument. One thread (the render
// loop's). A session has at most one view pending; the loop keeps the view itself and replaces it by a newer one
// without telling the scheduler.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "common/clock.h"
#include "common/ids.h"

namespace gnomon::scheduler {

class Scheduler {
 public:
  virtual ~Scheduler() = default;

  virtual std::string_view policy() const = 0;

  virtual void add_session(SessionId session, TenantId tenant) = 0;
  virtual void remove_session(SessionId session) = 0;  // forgets its pending view too

  // The session has a view to render. Saying so again before pick() is no news.
  virtual void make_ready(SessionId session, TimePoint now) = 0;

  // The next session to render, no longer ready; empty when none is.
  virtual std::optional<SessionId> pick(TimePoint now) = 0;

  // What a picked view really cost. May come after the session was removed.
  virtual void charge(SessionId session, Nanoseconds gpu_time, TimePoint now) = 0;
};

// Sessions in turn, whoever they belong to: the dissertation's policy (3.7) without its blocking on a silent one.
std::unique_ptr<Scheduler> make_round_robin();

}  // namespace gnomon::scheduler
