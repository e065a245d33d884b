// Checks the promise of scheduler.h over millions of picks, and that these checks detect broken policies.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "tests/unit/scheduler/broken_policies.h"
#include "tests/unit/scheduler/workload.h"

namespace gnomon::scheduler {
namespace {

void expect_clean(const Findings& found, uint64_t picks) {
  EXPECT_GE(found.picks, picks);
  EXPECT_LE(found.worst_lag, 1);
  EXPECT_LE(found.worst_wait, 1);
  EXPECT_EQ(found.idle_with_work, 0u);
  EXPECT_EQ(found.picks_without_job, 0u);
}

TEST(Promise, HoldsWhateverTenantsDo) {
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    const auto fair = make_fair();
    const Findings found = run(*fair, {.seed = seed, .picks = 500'000});
    SCOPED_TRACE(seed);
    expect_clean(found, 500'000);
    EXPECT_GT(found.worst_lag, 0.2) << "traffic that comes nowhere near the bound tests nothing";
  }
}

TEST(Promise, HoldsWithWrongPredictionsFailedJobsAndLostDevices) {
  for (const double error : {0.1, 0.5, 1.0}) {
    const auto fair = make_fair();
    const Findings found = run(*fair, {.seed = 11, .picks = 300'000, .error = error});
    SCOPED_TRACE(error);
    expect_clean(found, 300'000);
    EXPECT_GT(found.losses, 10u);
  }
}

TEST(Promise, HoldsForManyTenantsAndOneJobAtATime) {
  const auto fair = make_fair();
  expect_clean(run(*fair, {.seed = 5, .picks = 300'000, .tenants = 20, .max_sessions = 4, .in_flight = 1}),
               300'000);
}

TEST(Promise, BusyTenantsGetTheirWeightsToTheLastSlice) {
  const auto fair = make_fair();
  const Findings found = run(*fair, {.seed = 2,
                                     .picks = 300'000,
                                     .changes_weights = false,
                                     .sessions_come_and_go = false,
                                     .tenants_idle = false,
                                     .withdraws = false});
  expect_clean(found, 300'000);
  EXPECT_GT(found.jain, 0.999999);
}

// The same statement one level below: sessions of one tenant, equal weights, whatever other tenants do.
TEST(Promise, HoldsAmongTheSessionsOfATenant) {
  constexpr uint32_t kSessions = 8;
  constexpr double kLargest = 4e6;
  const auto fair = make_fair();
  std::mt19937_64 random(6);
  std::vector<double> service(kSessions + 1);
  const auto ask = [&](uint64_t session) {  // each has jobs of its own size; number 8 is another tenant's
    const auto most = static_cast<uint64_t>(kLargest) / (1 + session % 4);
    fair->make_ready(SessionId{session}, {Nanoseconds(1 + random() % most)}, {});
  };
  for (uint32_t tenant = 0; tenant < 2; ++tenant) fair->set_tenant(TenantId{tenant}, {.weight = 1 + tenant});
  for (uint32_t i = 0; i <= kSessions; ++i) {
    fair->add_session(SessionId{i}, TenantId{i / kSessions});
    ask(i);
  }
  double low = 0, high = 0;
  for (int i = 0; i < 200'000; ++i) {
    const auto ticket = fair->pick({});
    ASSERT_TRUE(ticket);
    service[ticket->session.value] += static_cast<double>(ticket->predicted.count());
    ask(ticket->session.value);
    for (uint32_t a = 0; a < kSessions; ++a) {
      for (uint32_t b = 0; b < a; ++b) {
        low = std::min(low, service[a] - service[b]);
        high = std::max(high, service[a] - service[b]);
      }
    }
    ASSERT_LE(high - low, 2 * 5 * kLargest) << i;  // of any two pairs: twice the bound of one
  }
}

TEST(Promise, RoundRobinKeepsTheDeviceBusyButNotTheShares) {
  const auto turns = make_round_robin();
  const Findings found = run(*turns, {.seed = 3});
  EXPECT_EQ(found.idle_with_work, 0u);
  EXPECT_EQ(found.picks_without_job, 0u);
  EXPECT_GT(found.worst_lag, 1);
}

TEST(Promise, EveryPolicyIsWorkConserving) {
  for (const std::string_view name : kPolicies) {
    const auto policy = make_scheduler(name, 0.1);
    const Findings found = run(*policy, {.seed = 4, .error = 0.3});
    EXPECT_EQ(found.idle_with_work, 0u) << name;
    EXPECT_EQ(found.picks_without_job, 0u) << name;
  }
}

// The checks detect each policy of broken_policies.h, which contains one mistake.
Findings found_of(broken::Choose choose, const Workload& workload) {
  broken::Policy policy(std::move(choose));
  return run(policy, workload);
}

TEST(BrokenPolicy, BankedCreditIsFound) { EXPECT_GT(found_of(broken::banks_credit(), {.seed = 1}).worst_lag, 1); }

TEST(BrokenPolicy, IgnoredWeightsAreFound) {
  EXPECT_GT(found_of(broken::ignores_weights(), {.seed = 1, .sessions_come_and_go = false, .tenants_idle = false})
                .worst_lag,
            1);
}

TEST(BrokenPolicy, StarvationIsFound) { EXPECT_GT(found_of(broken::heaviest_first(), {.seed = 1}).worst_wait, 1); }

TEST(BrokenPolicy, AnIdleDeviceIsFound) {
  EXPECT_GT(found_of(broken::keeps_the_device_idle(), {.seed = 1}).idle_with_work, 0u);
}

}  // namespace
}  // namespace gnomon::scheduler
