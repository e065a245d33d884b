// Earliest deadline first (Liu and Layland, "Scheduling Algorithms for Multiprogramming in a Hard-Real-Time
// Environment", 1973). A view that was begun is finished first, because an incomplete view is useless. A newer view
// keeps the place of the view that it replaces; otherwise a session that sends many views would never be served.
#include "scheduler/indexed_heap.h"
#include "scheduler/sessions.h"

namespace gnomon::scheduler {
namespace {

struct Session {
  SessionId id;
  TenantId tenant;
  Request request;
  TimePoint place;  // what it is queued by: the deadline of the first of the views that replaced each other
};

// Key of the queue: sessions with equal deadlines, or without one, are served in the order in which they became ready.
struct Urgency {
  TimePoint deadline;
  uint64_t turn = 0;
  friend auto operator<=>(const Urgency&, const Urgency&) = default;
};

class Deadline final : public Scheduler {
 public:
  std::string_view policy() const override { return "deadline"; }

  void set_tenant(TenantId tenant, const TenantScheduling&) override { services_.know(tenant); }

  void add_session(SessionId session, TenantId tenant) override {
    sessions_.add(session, Session{session, tenant, {}, {}});
    waiting_.reserve(sessions_.capacity());
  }

  void remove_session(SessionId session) override {
    withdraw(session);
    if (sessions_.find(session)) sessions_.remove(session);
  }

  void make_ready(SessionId session, const Request& request, TimePoint) override {
    const auto number = sessions_.find(session);
    if (!number) return;
    Session& s = sessions_[*number];
    s.request = request;
    s.request.cost = charged_cost(request);
    if (waiting_.contains(*number) && s.place <= request.deadline) return;
    s.place = request.continues ? TimePoint::min() : request.deadline;
    waiting_.set(*number, {s.place, ++turns_});
  }

  void withdraw(SessionId session) override {
    if (const auto number = sessions_.find(session)) waiting_.erase(*number);
  }

  std::optional<Ticket> pick(TimePoint) override {
    if (waiting_.empty()) return std::nullopt;
    const Session& session = sessions_[waiting_.top()];
    waiting_.erase(waiting_.top());
    services_.charge(session.tenant, session.request.cost);
    return Ticket{session.id, session.tenant, session.request.cost};
  }

  void charge(const Ticket& ticket, Nanoseconds gpu_time, TimePoint) override {
    services_.charge(ticket.tenant, gpu_time - ticket.predicted);
  }

  // Only the head of the queue is examined: every session passes it before it is picked.
  std::optional<SessionId> take_expired(TimePoint now) override {
    if (waiting_.empty() || waiting_.top_key().deadline == TimePoint::min()) return std::nullopt;
    const Session& session = sessions_[waiting_.top()];
    if (session.request.deadline - now >= session.request.cost) return std::nullopt;
    waiting_.erase(waiting_.top());
    return session.id;
  }

  TenantStanding standing(TenantId tenant) const override { return {services_.of(tenant), {}}; }

 private:
  SessionStates<Session> sessions_;
  IndexedHeap<Urgency> waiting_;
  uint64_t turns_ = 0;
  Services services_;
};

}  // namespace

std::unique_ptr<Scheduler> make_deadline() { return std::make_unique<Deadline>(); }

}  // namespace gnomon::scheduler
