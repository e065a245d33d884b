// The sessions of a device and how they stand in line for it: in the scheduler's queue, or held back by a rate.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <unordered_map>

#include "daemon/config/sharing_policy.h"
#include "daemon/render/render_session.h"
#include "daemon/render/scene_costs.h"
#include "daemon/render/share_account.h"

namespace gnomon::daemon {

// Owns the table of sessions, the scheduler and the accounts of tenants. The render thread's; told the time.
class RenderQueue {
 public:
  // `usual_quantum`: of the device's kind, where the terms leave it open. References outlive the queue.
  RenderQueue(const SharingPolicy& terms, Nanoseconds usual_quantum, SceneCosts& costs, FrameSink& sink,
              Metrics& metrics);

  // Another policy starts with everybody who waits; what was charged before is not held against anybody.
  void set_terms(const SharingPolicy& terms, TimePoint now);
  const SharingPolicy& sharing() const { return sharing_; }
  Nanoseconds quantum() const { return sharing_.quantum.value_or(usual_quantum_); }  // 0: frames are never cut

  using Sessions = std::unordered_map<SessionId, RenderSession>;
  Sessions& sessions() { return sessions_; }
  RenderSession* find(SessionId id);  // null: there is no such session
  void open(const SessionOpened& opened);
  void close(SessionId id);  // precondition: the session is known, and its partial frame was given up

  // The session's next job, cut to the quantum, stands in the queue; in the place of the one that it had there.
  // Precondition: the session has work.
  void enqueue(RenderSession& session, TimePoint now);
  // The same as soon as the rates of its tenant and its own allow a frame.
  void enqueue_when_allowed(RenderSession& session, TimePoint now);
  void release_held(TimePoint now);
  // The session leaves the queue, if it stands there.
  void withdraw(RenderSession& session);
  // Jobs of the scene stand in the queue with what was believed of their costs when they got there.
  void requeue_scene(SceneId scene, TimePoint now);
  // The same, and what was learned of the sessions' views is void.
  void forget_costs(SceneId scene, TimePoint now);

  // Views that cannot be ready by their deadline cost nothing more.
  void drop_expired(TimePoint now);

  // Whose job is next: it leaves the queue, and its predicted cost is charged. Nullopt: nobody waits.
  struct Picked {
    RenderSession& session;
    scheduler::Ticket ticket;
  };
  std::optional<Picked> pick(TimePoint now);
  // `policy`: the one that gave the ticket out; what an earlier one charged is forgotten.
  uint64_t policy() const { return policy_; }
  void charge(const scheduler::Ticket& ticket, uint64_t policy, Nanoseconds cost, TimePoint now);
  // What was picked just now is not done, and costs nothing.
  void refund(const scheduler::Ticket& ticket, TimePoint now) { charge(ticket, policy_, Nanoseconds{}, now); }

  void cut_next_job(RenderSession& session) { cut_next_job(session, quantum()); }
  void cut_next_job(RenderSession& session, Nanoseconds quantum);

  TimePoint held_until() const { return held_.empty() ? TimePoint::max() : held_.begin()->first; }
  ShareAccount& account() { return account_; }
  ShareReport shares() { return account_.report(*scheduler_); }  // since the last call

 private:
  const Nanoseconds usual_quantum_;
  SceneCosts& costs_;
  FrameSink& sink_;
  Metrics& metrics_;
  SharingPolicy sharing_;
  std::unique_ptr<scheduler::Scheduler> scheduler_;
  uint64_t policy_ = 0;  // counts the schedulers that there were
  ShareAccount account_;
  Sessions sessions_;
  std::multimap<TimePoint, SessionId> held_;  // until then they may not enter the queue
};

}  // namespace gnomon::daemon
