#include <gtest/gtest.h>

#include <map>
#include <random>

#include "scheduler/scheduler.h"

namespace gnomon::scheduler {
namespace {

using namespace std::chrono_literals;
constexpr TimePoint kNow{};

// Tenant i has priority i and one session, whose id is i.
std::unique_ptr<Scheduler> with_classes(uint32_t classes, double floor) {
  auto scheduler = make_priority(floor);
  for (uint32_t i = 0; i < classes; ++i) {
    scheduler->set_tenant(TenantId{i}, {.weight = 1, .priority = i});
    scheduler->add_session(SessionId{i}, TenantId{i});
  }
  return scheduler;
}

// Returns the service of each class while every session always has a job.
std::map<uint64_t, Nanoseconds> flood(Scheduler& scheduler, uint32_t classes, int jobs) {
  std::map<uint64_t, Nanoseconds> service;
  for (uint32_t i = 0; i < classes; ++i) scheduler.make_ready(SessionId{i}, {1ms}, kNow);
  for (int i = 0; i < jobs; ++i) {
    const auto ticket = scheduler.pick(kNow);
    service[ticket->session.value] += ticket->predicted;
    scheduler.charge(*ticket, ticket->predicted, kNow);
    scheduler.make_ready(ticket->session, {1ms}, kNow);
  }
  return service;
}

TEST(Priority, TheHighestClassWithWorkIsServed) {
  auto scheduler = with_classes(4, 0);
  std::mt19937 random(3);
  std::vector<bool> ready(4);
  for (int step = 0; step < 100'000; ++step) {
    const uint32_t session = random() % 4;
    if (random() % 2) {
      scheduler->make_ready(SessionId{session}, {1ms}, kNow);
      ready[session] = true;
      continue;
    }
    const auto ticket = scheduler->pick(kNow);
    const auto highest = std::find(ready.rbegin(), ready.rend(), true);
    ASSERT_EQ(ticket.has_value(), highest != ready.rend());
    if (!ticket) continue;
    ASSERT_EQ(ticket->session.value, static_cast<uint64_t>(ready.rend() - highest - 1));
    ready[ticket->session.value] = false;
  }
}

TEST(Priority, TheFloorKeepsLowerClassesAlive) {
  auto scheduler = with_classes(3, 0.2);
  auto service = flood(*scheduler, 3, 10'000);
  EXPECT_NEAR(to_seconds(service[2]), 8.0, 0.01);
  EXPECT_NEAR(to_seconds(service[1]), 1.6, 0.01);
  EXPECT_NEAR(to_seconds(service[0]), 0.4, 0.01);
}

TEST(Priority, WithoutAFloorTheyWait) {
  auto scheduler = with_classes(2, 0);
  EXPECT_EQ(flood(*scheduler, 2, 1000)[1], Nanoseconds(1s));
}

TEST(Priority, ClassesThatWereAloneOweNothing) {
  auto scheduler = with_classes(2, 0.5);
  scheduler->make_ready(SessionId{1}, {1ms}, kNow);
  for (int i = 0; i < 1000; ++i) {
    scheduler->charge(*scheduler->pick(kNow), 1ms, kNow);
    scheduler->make_ready(SessionId{1}, {1ms}, kNow);
  }
  EXPECT_NEAR(to_seconds(flood(*scheduler, 2, 100)[0]), 0.05, 0.002);
}

TEST(Priority, ATenantCanChangeItsClassWithViewsWaiting) {
  auto scheduler = with_classes(2, 0);
  scheduler->make_ready(SessionId{0}, {1ms}, kNow);
  scheduler->make_ready(SessionId{1}, {1ms}, kNow);
  scheduler->set_tenant(TenantId{0}, {.weight = 1, .priority = 7});
  EXPECT_EQ(scheduler->pick(kNow)->session, SessionId{0});
  EXPECT_EQ(scheduler->pick(kNow)->session, SessionId{1});
  EXPECT_FALSE(scheduler->pick(kNow));
}

TEST(Priority, ARemovedSessionIsForgottenAndItsNumberCanComeBack) {
  auto scheduler = with_classes(2, 0);
  scheduler->make_ready(SessionId{1}, {1ms}, kNow);
  scheduler->remove_session(SessionId{1});
  scheduler->make_ready(SessionId{1}, {1ms}, kNow);  // a request that arrives after the session was removed
  EXPECT_FALSE(scheduler->pick(kNow));
  scheduler->add_session(SessionId{1}, TenantId{0});
  scheduler->make_ready(SessionId{1}, {1ms}, kNow);
  EXPECT_EQ(scheduler->pick(kNow)->tenant, TenantId{0});
}

TEST(Priority, AStandingIsWhatATenantWasChargedAndIsOwed) {
  auto scheduler = with_classes(2, 0);
  scheduler->set_tenant(TenantId{0}, {.weight = 1, .priority = 1});  // the other tenant's priority
  for (const uint64_t session : {0, 1}) scheduler->make_ready(SessionId{session}, {2ms}, kNow);
  const auto ticket = scheduler->pick(kNow);
  const TenantId other{1 - ticket->tenant.value};
  EXPECT_EQ(scheduler->standing(ticket->tenant).lag, Nanoseconds(-1ms));
  EXPECT_EQ(scheduler->standing(other).lag, Nanoseconds(1ms));
  scheduler->charge(*ticket, 3ms, kNow);
  EXPECT_EQ(scheduler->standing(ticket->tenant).service, Nanoseconds(3ms));
  EXPECT_EQ(scheduler->standing(other).service, Nanoseconds(0));
  EXPECT_EQ(scheduler->standing(TenantId{99}).service, Nanoseconds(0)) << "of a tenant that nobody knows";
}

}  // namespace
}  // namespace gnomon::scheduler
