// Decides which session's job the device does next.
//
// A scheduler knows tenants, sessions and costs, but no views, no GPU and no clock: time is an argument. It is used by
// one thread, the render loop's. A session requests one job at a time: a complete view, or the next band of a view that
// was divided because it costs more than a quantum. The render loop keeps the view itself and may replace it by a newer
// one without notifying the scheduler.
//
// The promise of `fair`, proved in PROMISE.md and tested in tests/unit/scheduler: let two tenants i and j have work
// waiting all through an interval, with weights w and services S (device time charged). With L the largest cost of a
// job, then
//
//   |S_i / w_i - S_j / w_j|  <=  2 L (1 / w_i + 1 / w_j)  +  2 L / (w_i + w_j)
//
// whatever others do, if predictions are exact; PROMISE.md states what inexact ones add. The policy is work-conserving,
// an idle tenant accumulates no credit, and the same holds for the sessions of a tenant among themselves, with equal
// weights.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "common/clock.h"
#include "common/ids.h"

namespace gnomon::scheduler {

struct TenantScheduling {
  uint32_t weight = 1;    // share of the device relative to the other tenants' weights; at least 1
  uint32_t priority = 0;  // class under the policy `priority`: higher classes are served first
  friend bool operator==(const TenantScheduling&, const TenantScheduling&) = default;
};

// A job that a session requests.
struct Request {
  Nanoseconds cost{};                     // predicted; at least 1 ns is charged
  TimePoint deadline = TimePoint::max();  // the result is useless after it; max: no deadline
  bool continues = false;                 // the next band of the view that the session was picked for last
};

// A job that was picked. It is passed to charge() exactly once.
struct Ticket {
  SessionId session;
  TenantId tenant;
  Nanoseconds predicted{};  // charged already
};

// A tenant's account.
struct TenantStanding {
  Nanoseconds service{};  // device time charged since the first set_tenant
  Nanoseconds lag{};      // service that it is owed (positive) or has had in advance; 0 if the policy promises none
};

class Scheduler {
 public:
  virtual ~Scheduler() = default;

  virtual std::string_view policy() const = 0;

  // Adds a tenant, or changes its terms. A lower weight takes effect when the tenant has worked off the service that it
  // has had in advance, which is before its next job is picked. Precondition of all other calls: the session's tenant
  // was added.
  virtual void set_tenant(TenantId tenant, const TenantScheduling& scheduling) = 0;

  // Precondition: the session was not added before, or was removed.
  virtual void add_session(SessionId session, TenantId tenant) = 0;
  // Also withdraws the session's request. Idempotent.
  virtual void remove_session(SessionId session) = 0;

  // The session has a job. A second request before pick() replaces the first. Ignored if the session is unknown.
  virtual void make_ready(SessionId session, const Request& request, TimePoint now) = 0;
  // The session has no job any more, because its view was cancelled. Ignored if the session is unknown or has no job.
  virtual void withdraw(SessionId session) = 0;

  // The next job, whose predicted cost is charged at once; nullopt if no session has a job. Does not allocate.
  virtual std::optional<Ticket> pick(TimePoint now) = 0;

  // Replaces the predicted cost of a job by the measured one: 0 if the job was never done (refused, device lost). May
  // be called after the session was removed.
  virtual void charge(const Ticket& ticket, Nanoseconds gpu_time, TimePoint now) = 0;

  // Removes the job of one session that can no longer meet its deadline, without charging it; nullopt if there is none.
  virtual std::optional<SessionId> take_expired(TimePoint) { return std::nullopt; }

  virtual TenantStanding standing(TenantId tenant) const = 0;
};

// Weighted fair queueing over tenants, then equal shares over a tenant's sessions (EEVDF, see virtual_queue.h).
std::unique_ptr<Scheduler> make_fair();

// Strict priority classes, with `fair` inside each class. If `floor` is above 0 (and below 1), the classes below the
// highest one that has work get that share of the device together, so that they cannot starve.
std::unique_ptr<Scheduler> make_priority(double floor = 0);

// Earliest deadline first; requests without a deadline come last, in the order in which they became ready. A view that
// cannot be ready in time by its predicted cost is returned by take_expired.
std::unique_ptr<Scheduler> make_deadline();

// Round robin over sessions, whatever their tenants: the dissertation's policy (3.7), but without blocking on a silent
// session.
std::unique_ptr<Scheduler> make_round_robin();

// Makes the policy of that name, one of kPolicies; nullptr if there is no such policy.
std::unique_ptr<Scheduler> make_scheduler(std::string_view policy, double priority_floor);
inline constexpr std::string_view kPolicies[] = {"fair", "priority", "deadline", "round_robin"};

}  // namespace gnomon::scheduler
