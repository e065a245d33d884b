// Whose work the device does next.
//
// A scheduler knows tenants, sessions and costs; no views, no GPU, no clock: time is an argument. One thread (the
// render loop's). A session asks for one job at a time: a whole view, or the next band of one that was cut because it
// costs more than a quantum. The loop keeps the view itself and may replace it by a newer one without telling anybody.
//
// The promise of `fair`, proved in PROMISE.md and tested in tests/unit/scheduler: let two tenants i and j have work waiting
// all through an interval, with weights w and services S (device time charged). With L the largest cost of a job, then
//
//   |S_i / w_i - S_j / w_j|  <=  2 L (1 / w_i + 1 / w_j)  +  2 L / (w_i + w_j)
//
// whatever others do, when predictions are exact; PROMISE.md says what wrong ones add. It is work-conserving, an idle
// tenant banks no credit, and the same holds for the sessions of a tenant among themselves, with equal weights.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "common/clock.h"
#include "common/ids.h"

namespace gnomon::scheduler {

struct TenantTerms {
  uint32_t weight = 1;    // share of the device, relative to the other tenants'; at least 1
  uint32_t priority = 0;  // class under `priority`: higher ones first
  friend bool operator==(const TenantTerms&, const TenantTerms&) = default;
};

struct Request {
  Nanoseconds cost{};                     // predicted; at least 1 ns is charged
  TimePoint deadline = TimePoint::max();  // of use until then; max: not said
  bool continues = false;                 // the next band of the view that the session was picked for last
};

// A job that was picked, to be charged once.
struct Ticket {
  SessionId session;
  TenantId tenant;
  Nanoseconds predicted{};  // charged already
};

// How a tenant stands.
struct Standing {
  Nanoseconds service{};  // charged since the tenant is known
  Nanoseconds lag{};      // what it is owed (positive) or has had in advance; 0 under policies that promise nothing
};

class Scheduler {
 public:
  virtual ~Scheduler() = default;

  virtual std::string_view policy() const = 0;

  // Makes a tenant known, or changes its terms. A lower weight counts from when the tenant has caught up with what it
  // has had in advance: at most one job later. Precondition of all that follows: the session's tenant is known.
  virtual void set_tenant(TenantId tenant, const TenantTerms& terms) = 0;

  virtual void add_session(SessionId session, TenantId tenant) = 0;
  virtual void remove_session(SessionId session) = 0;  // forgets its request too

  // The session has a job. A second request before pick() replaces the first. Of no known session: no news.
  virtual void make_ready(SessionId session, const Request& request, TimePoint now) = 0;
  // It has none any more (its view was cancelled).
  virtual void withdraw(SessionId session) = 0;

  // The next job, whose predicted cost is charged from now on; empty when there is none. No allocation.
  virtual std::optional<Ticket> pick(TimePoint now) = 0;

  // What a job really cost, in the place of what was predicted: 0 if it was never done (refused, device lost). May
  // come after the session was removed.
  virtual void charge(const Ticket& ticket, Nanoseconds gpu_time, TimePoint now) = 0;

  // Takes out one session whose job can no longer make its deadline, so that it costs nothing; empty: there is none.
  virtual std::optional<SessionId> take_expired(TimePoint) { return std::nullopt; }

  virtual Standing standing(TenantId tenant) const = 0;
};

// Weighted fair queueing over tenants, then equal shares over a tenant's sessions (EEVDF).
std::unique_ptr<Scheduler> make_fair();

// Strict classes, inside a class `fair`. Where `floor` is above 0 (and below 1), classes below the highest one that
// has work get that share of the device together, so that they cannot starve.
std::unique_ptr<Scheduler> make_priority(double floor = 0);

// Earliest deadline first; requests without one come last, in turn. A view that cannot be ready in time by its
// predicted cost is hopeless.
std::unique_ptr<Scheduler> make_deadline();

// Sessions in turn, whoever they belong to: the dissertation's policy (3.7) without its blocking on a silent one.
std::unique_ptr<Scheduler> make_round_robin();

// By the name in the configuration; null: there is no such policy.
std::unique_ptr<Scheduler> make_scheduler(std::string_view policy, double priority_floor);
inline constexpr std::string_view kPolicies[] = {"fair", "priority", "deadline", "round_robin"};

}  // namespace gnomon::scheduler
