#include <gtest/gtest.h>

#include <map>
#include <random>
#include <vector>

#include "scheduler/scheduler.h"

namespace gnomon::scheduler {
namespace {

constexpr TimePoint kNow{};
constexpr TenantId kTenant{0};
constexpr SessionId kA{11}, kB{22}, kC{33};

std::unique_ptr<Scheduler> with_sessions(std::initializer_list<SessionId> sessions) {
  auto scheduler = make_round_robin();
  for (const SessionId session : sessions) scheduler->add_session(session, kTenant);
  return scheduler;
}

TEST(RoundRobin, PicksNothingWhenNobodyIsReady) {
  auto scheduler = with_sessions({kA, kB});
  EXPECT_FALSE(scheduler->pick(kNow));
}

TEST(RoundRobin, PicksInTheOrderOfBecomingReady) {
  auto scheduler = with_sessions({kA, kB, kC});
  for (const SessionId session : {kC, kA, kB}) scheduler->make_ready(session, kNow);
  for (const SessionId expected : {kC, kA, kB}) EXPECT_EQ(scheduler->pick(kNow), expected);
  EXPECT_FALSE(scheduler->pick(kNow));
}

TEST(RoundRobin, ReadyTwiceIsOneTurn) {
  auto scheduler = with_sessions({kA, kB});
  scheduler->make_ready(kA, kNow);
  scheduler->make_ready(kB, kNow);
  scheduler->make_ready(kA, kNow);
  EXPECT_EQ(scheduler->pick(kNow), kA);
  EXPECT_EQ(scheduler->pick(kNow), kB);
  EXPECT_FALSE(scheduler->pick(kNow));
}

TEST(RoundRobin, RemovalForgetsThePendingView) {
  auto scheduler = with_sessions({kA, kB, kC});
  for (const SessionId session : {kA, kB, kC}) scheduler->make_ready(session, kNow);
  scheduler->remove_session(kB);
  scheduler->make_ready(kB, kNow);  // late news of a session that has gone
  EXPECT_EQ(scheduler->pick(kNow), kA);
  EXPECT_EQ(scheduler->pick(kNow), kC);
  EXPECT_FALSE(scheduler->pick(kNow));
}

TEST(RoundRobin, ChargeAfterRemovalIsHarmless) {
  auto scheduler = with_sessions({kA, kB});
  scheduler->make_ready(kA, kNow);
  scheduler->make_ready(kB, kNow);
  EXPECT_EQ(scheduler->pick(kNow), kA);
  scheduler->remove_session(kA);
  scheduler->charge(kA, std::chrono::milliseconds(3), kNow);
  EXPECT_EQ(scheduler->pick(kNow), kB);
  scheduler->remove_session(kA);  // twice is no news either
  EXPECT_FALSE(scheduler->pick(kNow));
}

TEST(RoundRobin, BackloggedSessionsGetEqualTurns) {
  auto scheduler = with_sessions({kA, kB, kC});
  std::map<SessionId, int> turns;
  for (const SessionId session : {kA, kB, kC}) scheduler->make_ready(session, kNow);
  for (int i = 0; i < 3000; ++i) {
    const auto session = scheduler->pick(kNow);
    ASSERT_TRUE(session);
    ++turns[*session];
    scheduler->charge(*session, std::chrono::microseconds(*session == kA ? 9000 : 10), kNow);
    scheduler->make_ready(*session, kNow);
  }
  for (const auto& [session, count] : turns) EXPECT_EQ(count, 1000) << session.value;
}

// Whoever floods, joins or leaves: between becoming ready and being picked, every other session is picked at most
// once.
TEST(RoundRobin, NobodyStarvesUnderRandomTraffic) {
  auto scheduler = make_round_robin();
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
      scheduler->make_ready(session, kNow);
      passed_by.try_emplace(session);
    } else {
      const auto session = scheduler->pick(kNow);
      ASSERT_EQ(session.has_value(), !passed_by.empty());
      if (!session) continue;
      ASSERT_EQ(passed_by.erase(*session), 1u) << "picked without being ready";
      for (auto& [waiting, picks] : passed_by) ASSERT_LE(++picks[*session], 1) << waiting.value;
    }
  }
}

}  // namespace
}  // namespace gnomon::scheduler
