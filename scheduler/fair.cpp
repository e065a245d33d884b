// Two levels of VirtualQueue: tenants by weight, then the sessions of one tenant with equal weights. A frame that was
// begun is finished before another frame of its tenant is begun: bands let tenants overtake each other, while each
// tenant has at most one incomplete frame.
#include <memory>

#include "scheduler/sessions.h"
#include "scheduler/virtual_queue.h"

namespace gnomon::scheduler {
namespace {

using Member = VirtualQueue::Member;

double in_ns(Nanoseconds cost) { return static_cast<double>(cost.count()); }

struct Session {
  SessionId id;
  TenantId tenant;
  Member member = 0;  // in its tenant's queue
  bool ready = false;
  Request request;
};

struct Tenant {
  Member member = 0;  // in the queue of tenants
  VirtualQueue sessions;
  std::vector<uint32_t> numbers;   // by member: the session's number
  std::optional<uint32_t> picked;  // session picked since the last refresh
  std::optional<uint32_t> begun;   // session whose frame has further bands
  bool stale = false;              // its request to the queue of tenants may have changed
};

class Fair final : public Scheduler {
 public:
  std::string_view policy() const override { return "fair"; }

  void set_tenant(TenantId id, const TenantScheduling& scheduling) override {
    services_.know(id);
    while (tenants_.size() <= id.value) tenants_.emplace_back();
    auto& tenant = tenants_[id.value];
    if (tenant) return queue_.set_weight(tenant->member, scheduling.weight);
    tenant = std::make_unique<Tenant>();
    tenant->member = queue_.add(scheduling.weight);
    if (ids_.size() <= tenant->member) ids_.resize(tenant->member + 1);
    ids_[tenant->member] = id;
    stale_.reserve(tenants_.size());
  }

  void add_session(SessionId id, TenantId tenant_id) override {
    Tenant& tenant = *tenants_[tenant_id.value];
    const Member member = tenant.sessions.add(1);
    const uint32_t number = sessions_.add(id, Session{id, tenant_id, member, false, {}});
    if (tenant.numbers.size() <= member) tenant.numbers.resize(member + 1);
    tenant.numbers[member] = number;
  }

  void remove_session(SessionId id) override {
    const auto number = sessions_.find(id);
    if (!number) return;
    const Session& session = sessions_[*number];
    forget(*number);
    tenants_[session.tenant.value]->sessions.remove(session.member);
    sessions_.remove(id);
  }

  void make_ready(SessionId id, const Request& request, TimePoint) override {
    const auto number = sessions_.find(id);
    if (!number) return;
    Session& session = sessions_[*number];
    Tenant& tenant = *tenants_[session.tenant.value];
    session.ready = true;
    session.request = request;
    session.request.cost = charged_cost(request);
    if (request.continues) tenant.begun = *number;
    tenant.sessions.request(session.member, in_ns(session.request.cost));
    mark_stale(session.tenant);
  }

  void withdraw(SessionId id) override {
    if (const auto number = sessions_.find(id)) forget(*number);
  }

  std::optional<Ticket> pick(TimePoint) override {
    refresh();
    const auto best = queue_.best();
    if (!best) return std::nullopt;
    Tenant& tenant = *tenants_[ids_[*best].value];
    const uint32_t number = next_of(tenant);
    Session& session = sessions_[number];
    session.ready = false;
    tenant.picked = number;
    tenant.begun.reset();
    mark_stale(session.tenant);
    const Ticket ticket{session.id, session.tenant, session.request.cost};
    charge_both(session.tenant, session.member, ticket.predicted);
    return ticket;
  }

  void charge(const Ticket& ticket, Nanoseconds gpu_time, TimePoint) override {
    const auto number = sessions_.find(ticket.session);
    const auto member = number ? std::optional(sessions_[*number].member) : std::nullopt;
    charge_both(ticket.tenant, member, gpu_time - ticket.predicted);
  }

  TenantStanding standing(TenantId id) const override {
    if (id.value >= tenants_.size() || !tenants_[id.value]) return {};
    return {services_.of(id), Nanoseconds(static_cast<int64_t>(queue_.lag(tenants_[id.value]->member)))};
  }

 private:
  uint32_t next_of(Tenant& tenant) {
    return tenant.begun ? *tenant.begun : tenant.numbers[*tenant.sessions.best()];
  }

  void charge_both(TenantId id, std::optional<Member> session, Nanoseconds cost) {
    Tenant& tenant = *tenants_[id.value];
    if (session) tenant.sessions.charge(*session, in_ns(cost));
    queue_.charge(tenant.member, in_ns(cost));
    services_.charge(id, cost);
  }

  void mark_stale(TenantId id) {
    Tenant& tenant = *tenants_[id.value];
    if (!tenant.stale) stale_.push_back(id);
    tenant.stale = true;
  }

  // Removes the session's job from the queues.
  void forget(uint32_t number) {
    Session& session = sessions_[number];
    Tenant& tenant = *tenants_[session.tenant.value];
    session.ready = false;
    if (tenant.begun == number) tenant.begun.reset();
    if (tenant.picked == number) tenant.picked.reset();
    tenant.sessions.set_idle(session.member);
    mark_stale(session.tenant);
  }

  // Deferred to the next pick(), because only then it is known whether the session that was picked last has another
  // job. If it has, it continues without having been idle in between.
  void refresh() {
    for (const TenantId id : stale_) {
      Tenant& tenant = *tenants_[id.value];
      tenant.stale = false;
      if (tenant.picked && !sessions_[*tenant.picked].ready) {
        tenant.sessions.set_idle(sessions_[*tenant.picked].member);
      }
      tenant.picked.reset();
      if (tenant.begun || tenant.sessions.best()) {
        queue_.request(tenant.member, in_ns(sessions_[next_of(tenant)].request.cost));
      } else {
        queue_.set_idle(tenant.member);
      }
    }
    stale_.clear();
  }

  VirtualQueue queue_;                            // its members are tenants
  std::vector<TenantId> ids_;                     // by member of the queue
  std::vector<std::unique_ptr<Tenant>> tenants_;  // by id
  std::vector<TenantId> stale_;
  SessionStates<Session> sessions_;
  Services services_;
};

}  // namespace

std::unique_ptr<Scheduler> make_fair() { return std::make_unique<Fair>(); }

}  // namespace gnomon::scheduler
