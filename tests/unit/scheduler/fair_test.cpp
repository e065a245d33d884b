#include <gtest/gtest.h>

#include <map>

#include "scheduler/scheduler.h"

namespace gnomon::scheduler {
namespace {

using namespace std::chrono_literals;
constexpr TimePoint kNow{};
constexpr TenantId kOne{0}, kTwo{1};
constexpr SessionId kA{11}, kB{22}, kC{33};

class Fair : public testing::Test {
 protected:
  void SetUp() override {
    scheduler_->set_tenant(kOne, {.weight = 1});
    scheduler_->set_tenant(kTwo, {.weight = 1});
  }

  void ready(SessionId session, Nanoseconds cost = 1ms) { scheduler_->make_ready(session, {cost}, kNow); }

  // Picks `jobs` times; a session that is served requests its next job at once. Returns what each session was charged.
  std::map<SessionId, Nanoseconds> serve(int jobs, const std::map<SessionId, Nanoseconds>& costs) {
    std::map<SessionId, Nanoseconds> service;
    for (int i = 0; i < jobs; ++i) {
      const auto ticket = scheduler_->pick(kNow);
      if (!ticket) break;
      service[ticket->session] += ticket->predicted;
      scheduler_->charge(*ticket, ticket->predicted, kNow);
      ready(ticket->session, costs.at(ticket->session));
    }
    return service;
  }

  std::unique_ptr<Scheduler> scheduler_ = make_fair();
};

double ratio(Nanoseconds a, Nanoseconds b) { return to_seconds(a) / to_seconds(b); }

TEST_F(Fair, SharesFollowWeightsAndNotTheNumberOfSessionsOrTheirCosts) {
  scheduler_->set_tenant(kTwo, {.weight = 3});
  scheduler_->add_session(kA, kOne);
  scheduler_->add_session(kB, kOne);
  scheduler_->add_session(kC, kTwo);
  const std::map<SessionId, Nanoseconds> costs{{kA, 4ms}, {kB, 4ms}, {kC, 500us}};
  for (const auto& [session, cost] : costs) ready(session, cost);
  auto service = serve(8000, costs);
  EXPECT_NEAR(ratio(service[kC], service[kA] + service[kB]), 3, 0.02);
  EXPECT_NEAR(ratio(service[kA], service[kB]), 1, 0.02);
}

TEST_F(Fair, WhoWasIdleHasNoCredit) {
  scheduler_->add_session(kA, kOne);
  scheduler_->add_session(kB, kTwo);
  ready(kA);
  serve(10'000, {{kA, 1ms}});
  ready(kB);
  auto service = serve(100, {{kA, 1ms}, {kB, 1ms}});
  EXPECT_LE(service[kB], 52ms);
  EXPECT_GE(service[kB], 50ms);
}

TEST_F(Fair, ACheapRequestIsServedBeforeAnExpensiveOne) {
  scheduler_->add_session(kA, kOne);
  scheduler_->add_session(kB, kTwo);
  for (int i = 0; i < 100; ++i) {
    ready(kA, 4ms);
    serve(3, {{kA, 4ms}});
    ready(kB, 100us);  // after a pause
    EXPECT_EQ(scheduler_->pick(kNow)->session, kB) << i;
  }
}

TEST_F(Fair, ChargesCorrectWhatWasPredicted) {
  scheduler_->add_session(kA, kOne);
  scheduler_->add_session(kB, kTwo);
  std::map<SessionId, Nanoseconds> real;
  ready(kA);
  ready(kB);
  for (int i = 0; i < 4000; ++i) {
    const auto ticket = scheduler_->pick(kNow);
    const Nanoseconds cost = ticket->session == kA ? 3ms : 1ms;  // predicted: 1 ms
    real[ticket->session] += cost;
    scheduler_->charge(*ticket, cost, kNow);
    ready(ticket->session);
  }
  EXPECT_NEAR(ratio(real[kA], real[kB]), 1, 0.01);
  EXPECT_EQ(scheduler_->standing(kOne).service, real[kA]);
}

TEST_F(Fair, AFrameThatWasBegunIsFinishedBeforeAnotherOfItsTenant) {
  scheduler_->add_session(kA, kOne);
  scheduler_->add_session(kB, kOne);
  scheduler_->add_session(kC, kTwo);
  ready(kA);
  ready(kB);
  EXPECT_EQ(scheduler_->pick(kNow)->session, kA);
  scheduler_->make_ready(kA, {.cost = 1ms, .continues = true}, kNow);
  ready(kC, 100us);
  EXPECT_EQ(scheduler_->pick(kNow)->session, kC) << "another tenant passes between bands";
  EXPECT_EQ(scheduler_->pick(kNow)->session, kA);
  EXPECT_EQ(scheduler_->pick(kNow)->session, kB);
  EXPECT_FALSE(scheduler_->pick(kNow));
}

TEST_F(Fair, RemovalAndWithdrawalForgetTheJob) {
  for (const SessionId session : {kA, kB, kC}) {
    scheduler_->add_session(session, kOne);
    ready(session);
  }
  scheduler_->remove_session(kB);
  scheduler_->withdraw(kC);
  ready(kB);  // a request that arrives after the session was removed
  const auto ticket = scheduler_->pick(kNow);
  EXPECT_EQ(ticket->session, kA);
  EXPECT_FALSE(scheduler_->pick(kNow));
  scheduler_->remove_session(kA);
  scheduler_->charge(*ticket, 3ms, kNow);
  EXPECT_EQ(scheduler_->standing(kOne).service, Nanoseconds(3ms));
}

TEST_F(Fair, TheLagIsWhatATenantIsOwed) {
  scheduler_->add_session(kA, kOne);
  scheduler_->add_session(kB, kTwo);
  ready(kA, 2ms);
  ready(kB, 2ms);
  const auto first = scheduler_->pick(kNow);
  const TenantId other = first->tenant == kOne ? kTwo : kOne;
  EXPECT_EQ(scheduler_->standing(first->tenant).lag, Nanoseconds(-1ms));
  EXPECT_EQ(scheduler_->standing(other).lag, Nanoseconds(1ms));
}

}  // namespace
}  // namespace gnomon::scheduler
