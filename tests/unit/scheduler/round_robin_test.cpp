#include <gtest/gtest.h>

#include <map>
#include <random>
#include <vector>

#include "scheduler/scheduler.h"

namespace gnomon::scheduler {
namespace {

constexpr TimePoint kNow{};
constexpr TenantId kTenant{0};
constexpr Request kJob{std::chrono::milliseconds(1)};
constexpr SessionId kA{11}, kB{22}, kC{33};

std::unique_ptr<Scheduler> with_sessions(std::initializer_list<SessionId> sessions) {
  auto scheduler = make_round_robin();
  scheduler->set_tenant(kTenant, {});
  for (const SessionId session : sessions) scheduler->add_session(session, kTenant);
  return scheduler;
}

std::optional<SessionId> picked(Scheduler& scheduler) {
  const auto ticket = scheduler.pick(kNow);
  return ticket ? std::optional(ticket->session) : std::nullopt;
}

TEST(RoundRobin, PicksNothingWhenNobodyIsReady) {
  auto scheduler = with_sessions({kA, kB});
  EXPECT_FALSE(scheduler->pick(kNow));
}

TEST(RoundRobin, PicksInTheOrderOfBecomingReady) {
  auto scheduler = with_sessions({kA, kB, kC});
  for (const SessionId session : {kC, kA, kB}) scheduler->make_ready(session, kJob, kNow);
  for (const SessionId expected : {kC, kA, kB}) EXPECT_EQ(picked(*scheduler), expected);
  EXPECT_FALSE(scheduler->pick(kNow));
}

TEST(RoundRobin, ReadyTwiceIsOneTurn) {
  auto scheduler = with_sessions({kA, kB});
  scheduler->make_ready(kA, kJob, kNow);
  scheduler->make_ready(kB, kJob, kNow);
  scheduler->make_ready(kA, kJob, kNow);
  EXPECT_EQ(picked(*scheduler), kA);
  EXPECT_EQ(picked(*scheduler), kB);
  EXPECT_FALSE(scheduler->pick(kNow));
}

TEST(RoundRobin, RemovalForgetsThePendingView) {
  auto scheduler = with_sessions({kA, kB, kC});
  for (const SessionId session : {kA, kB, kC}) scheduler->make_ready(session, kJob, kNow);
  scheduler->remove_session(kB);
  scheduler->make_ready(kB, kJob, kNow);  // a request that arrives after the session was removed
  EXPECT_EQ(picked(*scheduler), kA);
  EXPECT_EQ(picked(*scheduler), kC);
  EXPECT_FALSE(scheduler->pick(kNow));
}

TEST(RoundRobin, ChargeAfterRemovalIsHarmless) {
  auto scheduler = with_sessions({kA, kB});
  scheduler->make_ready(kA, kJob, kNow);
  scheduler->make_ready(kB, kJob, kNow);
  const auto ticket = scheduler->pick(kNow);
  ASSERT_EQ(ticket->session, kA);
  scheduler->remove_session(kA);
  scheduler->charge(*ticket, std::chrono::milliseconds(3), kNow);
  EXPECT_EQ(picked(*scheduler), kB);
  scheduler->remove_session(kA);  // removing a session is idempotent
  EXPECT_FALSE(scheduler->pick(kNow));
}

TEST(RoundRobin, ATurnIsAWholeViewHoweverManyBands) {
  auto scheduler = with_sessions({kA, kB});
  scheduler->make_ready(kA, kJob, kNow);
  scheduler->make_ready(kB, kJob, kNow);
  for (int band = 0; band < 3; ++band) {
    EXPECT_EQ(picked(*scheduler), kA);
    if (band < 2) scheduler->make_ready(kA, {.cost = kJob.cost, .continues = true}, kNow);
  }
  EXPECT_EQ(picked(*scheduler), kB);
}

TEST(RoundRobin, BackloggedSessionsGetEqualTurns) {
  auto scheduler = with_sessions({kA, kB, kC});
  std::map<SessionId, int> turns;
  for (const SessionId session : {kA, kB, kC}) scheduler->make_ready(session, kJob, kNow);
  for (int i = 0; i < 3000; ++i) {
    const auto ticket = scheduler->pick(kNow);
    ASSERT_TRUE(ticket);
    ++turns[ticket->session];
    scheduler->charge(*ticket, std::chrono::microseconds(ticket->session == kA ? 9000 : 10), kNow);
    scheduler->make_ready(ticket->session, kJob, kNow);
  }
  for (const auto& [session, count] : turns) EXPECT_EQ(count, 1000) << session.value;
}

// Whichever sessions flood, join or leave: between becoming ready and being picked, a session sees every other session
// picked at most once.
TEST(RoundRobin, NobodyStarvesUnderRandomTraffic) {
  auto scheduler = with_sessions({});
  std::mt19937 random(7);
  std::vector<SessionId> present;
  std::map<SessionId, std::map<SessionId, int>> passed_by;  // ready session -> picks of others since
  uint64_t next = 1;
  for (int step = 0; step < 200'000; ++step) {
    const unsigned action = random() % 100;
    if (present.empty() || (action < 2 && present.size() < 50)) {
      present.push_back(SessionId{next++});
      scheduler->add_session(present.back(), kTenant);
    } else if (action < 3) {
      const size_t gone = random() % present.size();
      scheduler->remove_session(present[gone]);
      passed_by.erase(present[gone]);
      present.erase(present.begin() + static_cast<ptrdiff_t>(gone));
    } else if (action < 60) {
      const SessionId session = action < 30 ? present.front() : present[random() % present.size()];
      scheduler->make_ready(session, kJob, kNow);
      passed_by.try_emplace(session);
    } else {
      const auto session = picked(*scheduler);
      ASSERT_EQ(session.has_value(), !passed_by.empty());
      if (!session) continue;
      ASSERT_EQ(passed_by.erase(*session), 1u) << "picked without being ready";
      for (auto& [waiting, picks] : passed_by) ASSERT_LE(++picks[*session], 1) << waiting.value;
    }
  }
}

}  // namespace
}  // namespace gnomon::scheduler
