// Strict priority classes, each with a fair queue of its own. The floor applies between a class and all classes below
// it: while both have work, each job of the class adds the floor's share of its cost to a debt to the lower classes,
// and these are served first as long as the debt is positive.
#include <algorithm>
#include <map>

#include "scheduler/sessions.h"

namespace gnomon::scheduler {
namespace {

struct Class {
  std::unique_ptr<Scheduler> queue = make_fair();
  uint32_t ready = 0;  // number of sessions with a job
  double owed_ns = 0;  // device time owed to the classes below, by the floor
};

struct Session {
  SessionId id;
  TenantId tenant;
  std::optional<Request> request;  // nullopt if the session has no job
};

class Priority final : public Scheduler {
 public:
  explicit Priority(double floor) : floor_(floor) {}

  std::string_view policy() const override { return "priority"; }

  void set_tenant(TenantId id, const TenantScheduling& scheduling) override {
    services_.know(id);
    if (tenants_.size() <= id.value) tenants_.resize(id.value + 1);
    Tenant& tenant = tenants_[id.value];
    const bool moves = tenant.in && tenant.priority != scheduling.priority;
    if (moves) for_sessions_of(id, [&](uint32_t number) { take_out(number); });
    tenant = {&classes_[scheduling.priority], scheduling.priority};
    tenant.in->queue->set_tenant(id, scheduling);
    if (moves) for_sessions_of(id, [&](uint32_t number) { put_in(number); });
  }

  void add_session(SessionId session, TenantId tenant) override {
    const uint32_t number = sessions_.add(session, Session{session, tenant, {}});
    if (numbers_.size() <= number) numbers_.resize(number + 1);
    numbers_[number] = true;
    put_in(number);
  }

  void remove_session(SessionId session) override {
    const auto number = sessions_.find(session);
    if (!number) return;
    take_out(*number);
    numbers_[*number] = false;
    sessions_.remove(session);
  }

  void make_ready(SessionId session, const Request& request, TimePoint now) override {
    const auto number = sessions_.find(session);
    if (!number) return;
    Session& s = sessions_[*number];
    Class& in = *tenants_[s.tenant.value].in;
    if (!s.request) ++in.ready;
    s.request = request;
    in.queue->make_ready(session, request, now);
  }

  void withdraw(SessionId session) override {
    const auto number = sessions_.find(session);
    if (!number || !sessions_[*number].request) return;
    Class& in = *tenants_[sessions_[*number].tenant.value].in;
    --in.ready;
    sessions_[*number].request.reset();
    in.queue->withdraw(session);
  }

  std::optional<Ticket> pick(TimePoint now) override {
    const auto chosen = choose();
    if (chosen == classes_.end()) return std::nullopt;
    const auto ticket = chosen->second.queue->pick(now);
    --chosen->second.ready;
    sessions_[*sessions_.find(ticket->session)].request.reset();
    services_.charge(ticket->tenant, ticket->predicted);
    account(chosen, static_cast<double>(ticket->predicted.count()));
    return ticket;
  }

  void charge(const Ticket& ticket, Nanoseconds gpu_time, TimePoint now) override {
    tenants_[ticket.tenant.value].in->queue->charge(ticket, gpu_time, now);
    services_.charge(ticket.tenant, gpu_time - ticket.predicted);
  }

  TenantStanding standing(TenantId tenant) const override {
    if (tenant.value >= tenants_.size() || !tenants_[tenant.value].in) return {};
    return {services_.of(tenant), tenants_[tenant.value].in->queue->standing(tenant).lag};
  }

 private:
  using Classes = std::map<uint32_t, Class, std::greater<>>;  // highest first
  struct Tenant {
    Class* in = nullptr;
    uint32_t priority = 0;
  };

  bool any_below(Classes::iterator at) {
    return std::any_of(std::next(at), classes_.end(), [](const auto& below) { return below.second.ready > 0; });
  }

  Classes::iterator choose() {
    for (auto at = classes_.begin(); at != classes_.end(); ++at) {
      if (at->second.ready == 0) continue;
      if (!any_below(at)) at->second.owed_ns = 0;
      if (at->second.owed_ns <= 0) return at;
    }
    return classes_.end();
  }

  void account(Classes::iterator chosen, double cost_ns) {
    if (floor_ > 0 && any_below(chosen)) chosen->second.owed_ns += cost_ns * floor_;
    for (auto above = classes_.begin(); above != chosen; ++above) {
      if (above->second.ready > 0) above->second.owed_ns -= cost_ns * (1 - floor_);
    }
  }

  template <class Do>
  void for_sessions_of(TenantId tenant, Do act) {
    for (uint32_t number = 0; number < numbers_.size(); ++number) {
      if (numbers_[number] && sessions_[number].tenant == tenant) act(number);
    }
  }

  void put_in(uint32_t number) {
    const Session& session = sessions_[number];
    Class& in = *tenants_[session.tenant.value].in;
    in.queue->add_session(session.id, session.tenant);
    if (!session.request) return;
    ++in.ready;
    in.queue->make_ready(session.id, *session.request, TimePoint{});
  }

  void take_out(uint32_t number) {
    const Session& session = sessions_[number];
    Class& in = *tenants_[session.tenant.value].in;
    if (session.request) --in.ready;
    in.queue->remove_session(session.id);
  }

  const double floor_;
  Classes classes_;
  std::vector<Tenant> tenants_;  // by id
  SessionStates<Session> sessions_;
  std::vector<bool> numbers_;  // whether the session number is in use
  Services services_;
};

}  // namespace

std::unique_ptr<Scheduler> make_priority(double floor) { return std::make_unique<Priority>(floor); }

}  // namespace gnomon::scheduler
