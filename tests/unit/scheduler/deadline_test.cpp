#include <gtest/gtest.h>

#include <map>
#include <random>

#include "scheduler/scheduler.h"

namespace gnomon::scheduler {
namespace {

using namespace std::chrono_literals;
const TimePoint kNow = TimePoint(1h);

class Deadlines : public testing::Test {
 protected:
  void SetUp() override {
    scheduler_->set_tenant(TenantId{0}, {});
    for (uint64_t i = 0; i < 50; ++i) scheduler_->add_session(SessionId{i}, TenantId{0});
  }

  void ready(uint64_t session, Nanoseconds from_now, Nanoseconds cost = 1ms) {
    scheduler_->make_ready(SessionId{session}, {cost, kNow + from_now}, kNow);
  }
  std::optional<uint64_t> pick() {
    const auto ticket = scheduler_->pick(kNow);
    return ticket ? std::optional(ticket->session.value) : std::nullopt;
  }

  std::unique_ptr<Scheduler> scheduler_ = make_deadline();
};

TEST_F(Deadlines, TheMostUrgentFirstWhateverTheOrder) {
  std::mt19937 random(1);
  std::map<Nanoseconds, uint64_t> order;
  for (uint64_t i = 0; i < 50; ++i) {
    const auto deadline = std::chrono::microseconds(10'000 + random() % 1'000'000);
    order.emplace(deadline, i);
    ready(i, deadline);
  }
  for (const auto& [deadline, session] : order) EXPECT_EQ(pick(), session);
  EXPECT_FALSE(pick());
}

TEST_F(Deadlines, WithoutADeadlineLastAndInTurn) {
  scheduler_->make_ready(SessionId{1}, {1ms}, kNow);
  scheduler_->make_ready(SessionId{2}, {1ms}, kNow);
  ready(3, 1h);
  for (const uint64_t expected : {3, 1, 2}) EXPECT_EQ(pick(), expected);
}

TEST_F(Deadlines, TheHopelessAreTakenOutBeforeTheyCostAnything) {
  ready(1, 500us);  // costs 1 ms
  ready(2, -1s);
  ready(3, 1ms);
  ready(4, 5ms, 6ms);
  EXPECT_EQ(scheduler_->take_expired(kNow), SessionId{2});
  EXPECT_EQ(scheduler_->take_expired(kNow), SessionId{1});
  EXPECT_FALSE(scheduler_->take_expired(kNow));
  EXPECT_EQ(pick(), 3u);
  EXPECT_EQ(scheduler_->take_expired(kNow), SessionId{4});
  EXPECT_FALSE(pick());
  EXPECT_EQ(scheduler_->standing(TenantId{0}).service, Nanoseconds(1ms));
}

TEST_F(Deadlines, WhatWasBegunIsFinished) {
  ready(1, 10ms);
  EXPECT_EQ(pick(), 1u);
  scheduler_->make_ready(SessionId{1}, {1ms, kNow - 1s, true}, kNow);
  ready(2, 2ms);
  EXPECT_FALSE(scheduler_->take_expired(kNow));
  EXPECT_EQ(pick(), 1u);
  EXPECT_EQ(pick(), 2u);
}

TEST_F(Deadlines, ANewerViewTakesThePlaceOfTheOneItReplaces) {
  ready(1, 0ms);
  ready(2, 20ms);
  ready(1, 30ms);
  EXPECT_FALSE(scheduler_->take_expired(kNow)) << "the newer one can still be ready in time";
  EXPECT_EQ(pick(), 1u);
  EXPECT_EQ(pick(), 2u);
  ready(1, 30ms);
  ready(2, 20ms);
  ready(1, 10ms);
  EXPECT_EQ(pick(), 1u) << "it may also be more urgent";
}

TEST_F(Deadlines, WhoSendsManyViewsWithoutADeadlineKeepsItsTurn) {
  for (const uint64_t session : {1, 2, 1, 3, 1}) scheduler_->make_ready(SessionId{session}, {1ms}, kNow);
  for (const uint64_t expected : {1, 2, 3}) EXPECT_EQ(pick(), expected);
}

}  // namespace
}  // namespace gnomon::scheduler
