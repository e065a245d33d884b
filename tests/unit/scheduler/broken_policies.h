// Policies with one plausible mistake each. The checks of workload.h must detect every one.
#pragma once

#include <functional>
#include <vector>

#include "scheduler/scheduler.h"

namespace gnomon::scheduler::broken {

struct Account {
  double weight = 1;
  double service = 0;
  uint32_t ready = 0;
};

// Chooses the next of the tenants with work; nullopt if there is none. The mistake is in this function.
using Choose = std::function<std::optional<size_t>(const std::vector<Account>&)>;

// Serves the sessions of the chosen tenant in turn. Costs are charged correctly.
class Policy final : public Scheduler {
 public:
  explicit Policy(Choose choose) : choose_(std::move(choose)) {}

  std::string_view policy() const override { return "broken"; }
  void set_tenant(TenantId tenant, const TenantScheduling& terms) override {
    if (accounts_.size() <= tenant.value) accounts_.resize(tenant.value + 1);
    accounts_[tenant.value].weight = terms.weight;
  }
  void add_session(SessionId session, TenantId tenant) override { sessions_.push_back({session, tenant}); }
  void remove_session(SessionId session) override {
    withdraw(session);
    std::erase_if(sessions_, [&](const Session& s) { return s.id == session; });
  }
  void make_ready(SessionId session, const Request& request, TimePoint) override {
    for (Session& s : sessions_) {
      if (s.id != session) continue;
      if (!s.ready) ++accounts_[s.tenant.value].ready;
      s.ready = true;
      s.cost = request.cost;
    }
  }
  void withdraw(SessionId session) override {
    for (Session& s : sessions_) {
      if (s.id == session && s.ready) rest(s);
    }
  }
  std::optional<Ticket> pick(TimePoint) override {
    const auto tenant = choose_(accounts_);
    if (!tenant) return std::nullopt;
    for (size_t step = 0; step < sessions_.size(); ++step) {
      Session& s = sessions_[++turn_ % sessions_.size()];
      if (!s.ready || s.tenant.value != *tenant) continue;
      rest(s);
      accounts_[*tenant].service += static_cast<double>(s.cost.count());
      return Ticket{s.id, s.tenant, s.cost};
    }
    return std::nullopt;
  }
  void charge(const Ticket& ticket, Nanoseconds cost, TimePoint) override {
    accounts_[ticket.tenant.value].service += static_cast<double>((cost - ticket.predicted).count());
  }
  TenantStanding standing(TenantId) const override { return {}; }

 private:
  struct Session {
    SessionId id;
    TenantId tenant;
    bool ready = false;
    Nanoseconds cost{};
  };
  void rest(Session& s) {
    s.ready = false;
    --accounts_[s.tenant.value].ready;
  }

  Choose choose_;
  std::vector<Account> accounts_;
  std::vector<Session> sessions_;
  size_t turn_ = 0;
};

// The tenant with work for which `key` is least.
template <class KeyOf>
std::optional<size_t> least(const std::vector<Account>& accounts, KeyOf key) {
  std::optional<size_t> best;
  for (size_t i = 0; i < accounts.size(); ++i) {
    if (accounts[i].ready > 0 && (!best || key(accounts[i]) < key(accounts[*best]))) best = i;
  }
  return best;
}

// Respects weights but not idleness: a tenant that returns from idleness takes the complete device until it has caught
// up.
inline Choose banks_credit() {
  return [](const auto& all) { return least(all, [](const Account& a) { return a.service / a.weight; }); };
}

// Gives each tenant a turn, whatever its weight and the cost of its jobs.
inline Choose ignores_weights() {
  return [turn = size_t{0}](const auto& all) mutable -> std::optional<size_t> {
    for (size_t step = 0; step < all.size(); ++step) {
      if (all[++turn % all.size()].ready > 0) return turn % all.size();
    }
    return std::nullopt;
  };
}

// Always serves the tenant of the highest weight first, so that the others starve.
inline Choose heaviest_first() {
  return [](const auto& all) { return least(all, [](const Account& a) { return -a.weight; }); };
}

// Serves no tenant that is above its share, even if no other tenant has work.
inline Choose keeps_the_device_idle() {
  return [](const auto& all) -> std::optional<size_t> {
    const auto share = [](const Account& a) { return a.service / a.weight; };
    const auto best = least(all, share);
    double sum = 0;
    for (const Account& a : all) sum += share(a);
    if (best && share(all[*best]) > 1.5 * sum / static_cast<double>(all.size())) return std::nullopt;
    return best;
  };
}

}  // namespace gnomon::scheduler::broken
