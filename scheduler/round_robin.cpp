// Round robin over sessions. A session that becomes ready goes to the back of one queue. As it has at most one job
// pending, it is in the queue at most once, so a session waits for at most one view of each other session. A turn is a
// complete view: its further bands go to the front of the queue.
#include <list>

#include "scheduler/sessions.h"

namespace gnomon::scheduler {
namespace {

// A session keeps its list node and only moves it between the two lists: only add_session allocates, and every call is
// O(1).
struct Seat {
  std::list<uint32_t>::iterator node;
  SessionId id;
  TenantId tenant;
  bool ready = false;
  Nanoseconds cost{};
};

class RoundRobin final : public Scheduler {
 public:
  std::string_view policy() const override { return "round_robin"; }

  void set_tenant(TenantId tenant, const TenantScheduling&) override { services_.know(tenant); }

  void add_session(SessionId session, TenantId tenant) override {
    const uint32_t number = seats_.add(session, Seat{{}, session, tenant, false, {}});
    waiting_.push_front(number);
    seats_[number].node = waiting_.begin();
  }

  void remove_session(SessionId session) override {
    const auto number = seats_.find(session);
    if (!number) return;
    Seat& seat = seats_[*number];
    (seat.ready ? ready_ : waiting_).erase(seat.node);
    seats_.remove(session);
  }

  void make_ready(SessionId session, const Request& request, TimePoint) override {
    const auto number = seats_.find(session);
    if (!number) return;
    Seat& seat = seats_[*number];
    seat.cost = charged_cost(request);
    if (seat.ready) return;
    seat.ready = true;
    ready_.splice(request.continues ? ready_.begin() : ready_.end(), waiting_, seat.node);
  }

  void withdraw(SessionId session) override {
    const auto number = seats_.find(session);
    if (number && seats_[*number].ready) rest(seats_[*number]);
  }

  std::optional<Ticket> pick(TimePoint) override {
    if (ready_.empty()) return std::nullopt;
    Seat& seat = seats_[ready_.front()];
    rest(seat);
    services_.charge(seat.tenant, seat.cost);
    return Ticket{seat.id, seat.tenant, seat.cost};
  }

  // Only for standing(): the cost of a turn does not affect the order.
  void charge(const Ticket& ticket, Nanoseconds gpu_time, TimePoint) override {
    services_.charge(ticket.tenant, gpu_time - ticket.predicted);
  }

  TenantStanding standing(TenantId tenant) const override { return {services_.of(tenant), {}}; }

 private:
  void rest(Seat& seat) {
    seat.ready = false;
    waiting_.splice(waiting_.begin(), ready_, seat.node);
  }

  std::list<uint32_t> ready_;    // sessions with a job, in the order of their turns
  std::list<uint32_t> waiting_;  // sessions without a job, in no particular order
  SessionStates<Seat> seats_;
  Services services_;
};

}  // namespace

std::unique_ptr<Scheduler> make_round_robin() { return std::make_unique<RoundRobin>(); }

}  // namespace gnomon::scheduler
