// Sessions in turn. A session that becomes ready goes to the back of one queue; having at most one view pending, it
// can never stand in it twice, so nobody waits for more than one view of each other session.
#include <cassert>
#include <list>
#include <unordered_map>

#include "scheduler/scheduler.h"

namespace gnomon::scheduler {
namespace {

class RoundRobin final : public Scheduler {
 public:
  std::string_view policy() const override { return "round_robin"; }

  void add_session(SessionId session, TenantId) override {
    assert(!seats_.contains(session));
    waiting_.push_front(session);
    seats_.emplace(session, Seat{waiting_.begin(), false});
  }

  void remove_session(SessionId session) override {
    const auto found = seats_.find(session);
    if (found == seats_.end()) return;
    (found->second.ready ? ready_ : waiting_).erase(found->second.node);
    seats_.erase(found);
  }

  void make_ready(SessionId session, TimePoint) override {
    const auto found = seats_.find(session);
    if (found == seats_.end() || found->second.ready) return;
    found->second.ready = true;
    ready_.splice(ready_.end(), waiting_, found->second.node);
  }

  std::optional<SessionId> pick(TimePoint) override {
    if (ready_.empty()) return std::nullopt;
    const SessionId session = ready_.front();
    seats_.at(session).ready = false;
    waiting_.splice(waiting_.begin(), ready_, ready_.begin());
    return session;
  }

  void charge(SessionId, Nanoseconds, TimePoint) override {}  // a turn is a turn, whatever it cost

 private:
  // A session's list node lives as long as the session and only moves between the two lists: no call but
  // add_session allocates, and each is O(1).
  struct Seat {
    std::list<SessionId>::iterator node;
    bool ready;
  };

  std::list<SessionId> ready_;    // in the order of their turns
  std::list<SessionId> waiting_;  // without a view; order has no meaning
  std::unordered_map<SessionId, Seat> seats_;
};

}  // namespace

std::unique_ptr<Scheduler> make_round_robin() { return std::make_unique<RoundRobin>(); }

}  // namespace gnomon::scheduler
