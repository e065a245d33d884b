// gnomon-bench scheduler: the time of a pick as the number of sessions grows, a check that it allocates nothing, and
// how close shares come to the bound of `fair` (scheduler/PROMISE.md).
//
// Every session always has a job, which is the worst case. A step is what the render loop does for one job: pick,
// charge and make the session ready again.
#include <array>
#include <random>

#include "scheduler/scheduler.h"
#include "tests/bench/suites.h"
#include "tests/tools/allocations/allocations.h"
#include "tests/unit/scheduler/workload.h"

namespace gnomon::bench {
namespace {

using namespace scheduler;

constexpr uint32_t kTenants = 10;
constexpr int kRounds = 51;
constexpr int kPicksOfARound = 2000;

struct Figures {
  double pick_ns = 0;  // of the median round
  double step_ns = 0;
  double allocations_per_pick = 0;
};

class Bench {
 public:
  Bench(std::string_view policy, uint32_t sessions) : scheduler_(make_scheduler(policy, 0.1)) {
    for (uint32_t i = 0; i < kTenants; ++i) scheduler_->set_tenant(TenantId{i}, {1 + i % 4, i % 3});
    for (uint32_t i = 0; i < sessions; ++i) {
      const SessionId id{random_()};
      scheduler_->add_session(id, TenantId{i % kTenants});
      ask(id);
    }
  }

  Figures run() {
    round();
    std::vector<double> picks, steps;
    uint64_t allocated = 0;
    for (int i = 0; i < kRounds; ++i) {
      const uint64_t before = test::allocations();
      const auto [pick, step] = round();
      allocated += test::allocations() - before;
      picks.push_back(pick);
      steps.push_back(step);
    }
    return {median(picks), median(steps), static_cast<double>(allocated) / (double{kRounds} * kPicksOfARound)};
  }

 private:
  void ask(SessionId id) {
    const auto cost = Nanoseconds(100'000 + random_() % 4'000'000);
    scheduler_->make_ready(id, {cost, now_ + Nanoseconds(random_() % 1'000'000'000)}, now_);
  }

  // Means of a pick and of a step. All picks of a round are timed together, as one is as short as the clock's tick.
  std::pair<double, double> round() {
    Nanoseconds picking{};
    const TimePoint begin = Clock::now();
    for (int done = 0; done < kPicksOfARound; done += kBatch) {
      const TimePoint before = Clock::now();
      for (auto& ticket : batch_) ticket = *scheduler_->pick(now_);
      picking += Clock::now() - before;
      for (const Ticket& ticket : batch_) {
        scheduler_->charge(ticket, ticket.predicted + Nanoseconds(random_() % 10'000), now_);
        ask(ticket.session);
      }
    }
    const Nanoseconds all = Clock::now() - begin;
    return {static_cast<double>(picking.count()) / kPicksOfARound,
            static_cast<double>(all.count()) / kPicksOfARound};
  }

  static constexpr int kBatch = 5;
  static_assert(kPicksOfARound % kBatch == 0);

  std::mt19937_64 random_{1};
  TimePoint now_{std::chrono::hours(1)};
  std::array<Ticket, kBatch> batch_;
  std::unique_ptr<Scheduler> scheduler_;
};

class SchedulerSuite final : public Suite {
 public:
  void add_options(CLI::App& command) override {
    command.add_option("--sessions", sessions_, "how many have work waiting")->expected(1, 16);
  }

  Result<Report> run() override {
    Report report{.suite = "scheduler", .device = {}, .driver = {}, .rows = {}};
    for (const std::string_view policy : kPolicies) {
      double first = 0;
      for (const uint32_t sessions : sessions_) {
        if (sessions < kTenants) return Error{"--sessions: at least " + std::to_string(kTenants)};
        say(std::string(policy) + ", " + std::to_string(sessions) + " sessions");
        const Figures figures = Bench(policy, sessions).run();
        if (first == 0) first = figures.pick_ns;
        report.rows.push_back(row(policy, sessions, figures, figures.pick_ns / first));
      }
    }
    return report;
  }

 private:
  static nlohmann::ordered_json row(std::string_view policy, uint32_t sessions, const Figures& figures,
                                    double growth) {
    // Shares over random traffic in virtual time, relative to the bound of `fair`, which other policies do not promise.
    const auto fresh = make_scheduler(policy, 0.1);
    const Findings found = scheduler::run(
        *fresh, {.picks = 50'000, .tenants = kTenants, .max_sessions = std::max(1u, sessions / kTenants / 10)});
    return {{"policy", policy},
            {"sessions", sessions},
            {"pick_ns", figures.pick_ns},
            {"step_ns", figures.step_ns},
            {"growth", growth},
            {"allocations_per_pick", figures.allocations_per_pick},
            {"worst_lag", found.worst_lag},
            {"lag_bound", 1.0}};
  }

  std::vector<uint32_t> sessions_{10, 100, 1000, 10'000};
};

}  // namespace

std::unique_ptr<Suite> make_scheduler_suite() { return std::make_unique<SchedulerSuite>(); }

}  // namespace gnomon::bench
