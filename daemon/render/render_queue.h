// The sessions of a device and whether each is in the scheduler's queue or held back by a rate limit.
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

// Owns the table of sessions, the scheduler and the accounts of tenants. Belongs to the render thread; the caller
// passes the time.
class RenderQueue {
 public:
  // `usual_quantum`: of this kind of device, used if the sharing policy names none. All references outlive the queue.
  RenderQueue(const SharingPolicy& sharing, Nanoseconds usual_quantum, SceneCosts& costs, FrameSink& sink,
              Metrics& metrics);

  // If the policy changes, the new scheduler starts with all sessions that wait; earlier charges are forgotten.
  void set_sharing(const SharingPolicy& sharing, TimePoint now);
  const SharingPolicy& sharing() const { return sharing_; }
  Nanoseconds quantum() const { return sharing_.quantum.value_or(usual_quantum_); }  // 0: frames are never cut

  using Sessions = std::unordered_map<SessionId, RenderSession>;
  Sessions& sessions() { return sessions_; }
  RenderSession* find(SessionId id);  // nullptr if there is no such session
  void open(const SessionOpened& opened);
  void close(SessionId id);  // precondition: the session is known, and its partial frame was given up

  // Puts the session's next job, cut to the quantum, into the queue, in place of the job that it had there.
  // Precondition: the session has work.
  void enqueue(RenderSession& session, TimePoint now);
  // As enqueue(), as soon as the rates of the session and of its tenant allow a frame.
  void enqueue_when_allowed(RenderSession& session, TimePoint now);
  void release_held(TimePoint now);
  // Takes the session out of the queue; no effect if it is not there.
  void withdraw(RenderSession& session);
  // Queues the waiting jobs of the scene again with their costs as they are predicted now.
  void requeue_scene(SceneId scene, TimePoint now);
  // As requeue_scene(), and forgets what was learned of the costs of the sessions' views.
  void forget_costs(SceneId scene, TimePoint now);

  // Drops views that cannot be ready by their deadline before they are rendered.
  void drop_expired(TimePoint now);

  // Takes the session whose job is next out of the queue and charges the predicted cost; nullopt if no session waits.
  struct Picked {
    RenderSession& session;
    scheduler::Ticket ticket;
  };
  std::optional<Picked> pick(TimePoint now);
  // Replaces the predicted cost of the ticket by `cost`. `policy`: policy() when the ticket was issued; a ticket of an
  // earlier policy is ignored.
  uint64_t policy() const { return policy_; }
  void charge(const scheduler::Ticket& ticket, uint64_t policy, Nanoseconds cost, TimePoint now);
  // The picked job is not executed: its charge is taken back.
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
  uint64_t policy_ = 0;  // number of schedulers made so far
  ShareAccount account_;
  Sessions sessions_;
  std::multimap<TimePoint, SessionId> held_;  // by the time from which the session may enter the queue
};

}  // namespace gnomon::daemon
