#include "tests/unit/scheduler/workload.h"

#include <algorithm>
#include <deque>
#include <random>
#include <unordered_map>
#include <vector>

namespace gnomon::scheduler {
namespace {

double ns(Nanoseconds d) { return static_cast<double>(d.count()); }

// What one pair of tenants has had, while both had work waiting: S_i / w_i - S_j / w_j, and how far it ever moved.
struct Pair {
  bool watched = false;
  double now = 0, low = 0, high = 0;

  void start() { *this = {true, 0, 0, 0}; }
  void add(double difference) {
    now += difference;
    low = std::min(low, now);
    high = std::max(high, now);
  }
};

struct SimSession {
  SessionId id;
  uint32_t tenant = 0;
  bool ready = false;
  double think_ns = 0;     // until it asks again; 0: at once
  double asks_at_ns = 0;   // while not ready
  double waits_since = 0;  // total service when it became ready
};

struct SimTenant {
  double weight = 1;
  double service = 0;
  uint32_t sessions = 0;
  uint32_t ready = 0;
  bool idle = false;      // its sessions ask for nothing
  bool settling = false;  // a lower weight may not count yet
  bool had_work = false;  // at the last pick
};

class Run {
 public:
  Run(Scheduler& scheduler, const Workload& w) : scheduler_(scheduler), w_(w), random_(w.seed) {
    tenants_.resize(w_.tenants);
    pairs_.resize(size_t{w_.tenants} * w_.tenants);
    for (uint32_t t = 0; t < w_.tenants; ++t) {
      tenants_[t].weight = w_.equal_weights ? 1 : 1 + below(8);
      terms(t);
      for (uint32_t i = 0; i < 1 + below(w_.max_sessions); ++i) join(t);
    }
  }

  Findings run() {
    const uint64_t patience = 100 * w_.picks;  // bounds the run of a policy that picks nothing
    for (uint64_t step = 0; findings_.picks < w_.picks && step < patience; ++step, now_ns_ += 1000) {
      for (uint32_t action = below(4); action > 0; --action) disturb();
      wake_up();
      fill_device();
      if (!device_.empty()) complete();
    }
    findings_.jain = jain();
    return findings_;
  }

 private:
  uint32_t below(uint32_t n) { return static_cast<uint32_t>(random_() % n); }
  TimePoint now() const { return TimePoint(Nanoseconds(static_cast<int64_t>(now_ns_))); }
  void terms(uint32_t t) { scheduler_.set_tenant(TenantId{t}, {static_cast<uint32_t>(tenants_[t].weight), 0}); }

  void join(uint32_t t) {
    SimTenant& tenant = tenants_[t];
    if (tenant.sessions >= w_.max_sessions) return;
    ++tenant.sessions;
    SimSession session{SessionId{next_id_++}, t};
    const bool floods = below(2) == 0 || !w_.tenants_idle;
    session.think_ns = floods ? 0 : 1e6 * (1 + below(100));
    session.asks_at_ns = now_ns_;
    scheduler_.add_session(session.id, TenantId{t});
    index_[session.id] = sessions_.size();
    sessions_.push_back(session);
  }

  void leave(size_t at) {
    SimSession& session = sessions_[at];
    if (session.ready) --tenants_[session.tenant].ready;
    --tenants_[session.tenant].sessions;
    scheduler_.remove_session(session.id);
    index_.erase(session.id);
    session = sessions_.back();
    sessions_.pop_back();
    if (at < sessions_.size()) index_[session.id] = at;
  }

  // Changes something at random; most calls change nothing.
  void disturb() {
    const uint32_t dice = below(1000);
    const uint32_t t = below(w_.tenants);
    if (dice < 10 && w_.sessions_come_and_go) {
      join(t);
    } else if (dice < 18 && w_.sessions_come_and_go && !sessions_.empty()) {
      leave(below(static_cast<uint32_t>(sessions_.size())));
    } else if (dice < 20 && w_.changes_weights) {
      change_weight(t);
    } else if (dice < 22 && w_.tenants_idle) {
      tenants_[t].idle = !tenants_[t].idle;
    } else if (dice < 30 && w_.withdraws && !sessions_.empty()) {
      withdraw(sessions_[below(static_cast<uint32_t>(sessions_.size()))]);
    } else if (dice < 31 && w_.error > 0) {
      lose_device();
    }
  }

  void change_weight(uint32_t t) {
    const double weight = 1 + below(8);
    tenants_[t].settling = weight < tenants_[t].weight;
    tenants_[t].weight = weight;
    for (uint32_t other = 0; other < w_.tenants; ++other) pair(t, other).watched = false;
    terms(t);
  }

  void withdraw(SimSession& session) {
    if (!session.ready) return;
    session.ready = false;
    --tenants_[session.tenant].ready;
    session.asks_at_ns = now_ns_ + 1e6;
    scheduler_.withdraw(session.id);
  }

  void lose_device() {
    ++findings_.losses;
    for (const Job& job : device_) charge(job, 0);
    device_.clear();
  }

  void wake_up() {
    for (SimSession& session : sessions_) {
      if (!session.ready && session.asks_at_ns <= now_ns_ && !tenants_[session.tenant].idle) ask(session);
    }
  }

  void ask(SimSession& session) {
    // Small and large tenants differ: where all jobs cost the same, a policy that counts them would be fair.
    const double scale = (1.0 + session.tenant % 3) / 3;
    const double cost = std::max(1.0, w_.max_cost_ns * scale * (random_() % 1000 + 1) / 1000);
    session.ready = true;
    session.waits_since = total_service_;
    ++tenants_[session.tenant].ready;
    scheduler_.make_ready(session.id, {Nanoseconds(static_cast<int64_t>(cost)), TimePoint::max(), false}, now());
  }

  struct Job {
    Ticket ticket;
    double cost_ns;
  };

  void fill_device() {
    while (device_.size() < w_.in_flight) {
      watch_pairs();
      const auto ticket = scheduler_.pick(now());
      if (!ticket) {
        findings_.idle_with_work +=
            std::any_of(tenants_.begin(), tenants_.end(), [](auto& t) { return t.ready > 0; });
        return;
      }
      ++findings_.picks;
      take(*ticket);
    }
  }

  void take(const Ticket& ticket) {
    const auto found = index_.find(ticket.session);
    if (found == index_.end() || !sessions_[found->second].ready) {
      ++findings_.picks_without_job;
      return;
    }
    SimSession& session = sessions_[found->second];
    SimTenant& tenant = tenants_[session.tenant];
    session.ready = false;
    --tenant.ready;
    tenant.settling = false;
    session.asks_at_ns = now_ns_ + session.think_ns;
    check_wait(session);
    add_service(session.tenant, ns(ticket.predicted));
    const double error = w_.error * w_.max_cost_ns * (static_cast<double>(below(2001)) / 1000 - 1);
    const bool fails = w_.error > 0 && below(500) == 0;
    device_.push_back({ticket, fails ? 0 : std::max(1.0, ns(ticket.predicted) + error)});
    if (session.think_ns == 0 && !tenant.idle) ask(session);
  }

  void complete() {
    const Job job = device_.front();
    device_.pop_front();
    now_ns_ += job.cost_ns;
    charge(job, job.cost_ns);
  }

  void charge(const Job& job, double cost_ns) {
    const auto charged = Nanoseconds(static_cast<int64_t>(cost_ns));
    add_service(job.ticket.tenant.value, ns(charged - job.ticket.predicted));
    scheduler_.charge(job.ticket, charged, now());
  }

  Pair& pair(uint32_t i, uint32_t j) { return pairs_[size_t{std::min(i, j)} * w_.tenants + std::max(i, j)]; }

  void add_service(uint32_t t, double cost_ns) {
    total_service_ += cost_ns;
    tenants_[t].service += cost_ns;
    for (uint32_t other = 0; other < w_.tenants; ++other) {
      if (other == t || !pair(t, other).watched) continue;
      pair(t, other).add((t < other ? 1 : -1) * cost_ns / tenants_[t].weight);
      check_lag(t, other);
    }
  }

  // Two tenants are watched for as long as both have work at every pick.
  void watch_pairs() {
    for (uint32_t i = 0; i < w_.tenants; ++i) {
      const bool has_work = tenants_[i].ready > 0 && !tenants_[i].settling;
      const bool changed = has_work != tenants_[i].had_work;
      tenants_[i].had_work = has_work;
      for (uint32_t j = 0; j < w_.tenants; ++j) {
        if (j == i) continue;
        const bool both = has_work && tenants_[j].ready > 0 && !tenants_[j].settling;
        if (!both) pair(i, j).watched = false;
        if (both && (changed || !pair(i, j).watched)) pair(i, j).start();
      }
    }
  }

  // The bound (2) of PROMISE.md.
  void check_lag(uint32_t i, uint32_t j) {
    const double l = w_.max_cost_ns;
    const double e = w_.error > 0 ? w_.in_flight * l : 0;  // a job may turn out to cost nothing
    const double wi = tenants_[i].weight, wj = tenants_[j].weight;
    const double bound =
        2 * (l + e) * (1 / wi + 1 / wj) + 2 * (l + (w_.tenants + 1) * e) / (wi + wj) + 1;  // 1 ns: rounding
    const Pair& p = pair(i, j);
    findings_.worst_lag = std::max(findings_.worst_lag, (p.high - p.low) / bound);
  }

  void check_wait(const SimSession& session) {
    const double l = w_.max_cost_ns * (w_.error > 0 ? 1 + w_.in_flight * (w_.tenants + 1) : 1);
    double weights = 0;
    for (const SimTenant& tenant : tenants_) weights += w_.changes_weights ? 8 : tenant.weight;
    const double smallest = w_.changes_weights ? 1 : tenants_[session.tenant].weight;
    const double bound = weights / smallest * 3 * l * (w_.max_sessions + 1);
    findings_.worst_wait = std::max(findings_.worst_wait, (total_service_ - session.waits_since) / bound);
  }

  double jain() const {
    double sum = 0, squares = 0;
    for (const SimTenant& tenant : tenants_) {
      sum += tenant.service / tenant.weight;
      squares += tenant.service / tenant.weight * tenant.service / tenant.weight;
    }
    return sum * sum / (static_cast<double>(tenants_.size()) * squares);
  }

  Scheduler& scheduler_;
  const Workload w_;
  std::mt19937_64 random_;
  double now_ns_ = 0;
  double total_service_ = 0;
  uint64_t next_id_ = 1;
  std::vector<SimTenant> tenants_;
  std::vector<Pair> pairs_;
  std::vector<SimSession> sessions_;
  std::unordered_map<SessionId, size_t> index_;
  std::deque<Job> device_;
  Findings findings_;
};

}  // namespace

Findings run(Scheduler& scheduler, const Workload& workload) { return Run(scheduler, workload).run(); }

}  // namespace gnomon::scheduler
