#include "common/fair_queue.h"

#include <gtest/gtest.h>

#include <cctype>
#include <string>

#include "common/ids.h"

namespace gnomon {
namespace {

using Asker = std::optional<TenantId>;

const TenantId kGreedy{0}, kModest{1}, kThird{2};

// The requests in the order in which a single place serves them.
std::string served(FairQueue<Asker, std::string>& queue) {
  std::string order;
  while (const auto request = queue.start()) {
    order += *request;
    queue.done(std::isupper(request->front()) ? Asker(kModest) : Asker(kGreedy));
  }
  return order;
}

TEST(FairQueue, TenantsTakeTurnsHoweverManyOneAsksFor) {
  FairQueue<Asker, std::string> queue(1);
  for (const char* scene : {"a", "b", "c"}) queue.push(kGreedy, scene);
  queue.push(kModest, "D");
  EXPECT_EQ(served(queue), "aDbc");
}

TEST(FairQueue, WhoComesLaterWaitsForNoQueueOfAnother) {
  FairQueue<Asker, int> queue(100);
  for (int i = 0; i < 100; ++i) queue.push(TenantId{3}, i);
  EXPECT_EQ(queue.start(), 0);
  queue.push(TenantId{1}, -1);
  EXPECT_EQ(queue.start(), -1);
  EXPECT_EQ(queue.start(), 1);
}

TEST(FairQueue, OneTenantLeavesPlacesToTheOthers) {
  FairQueue<Asker, std::string> queue(4);
  for (int i = 0; i < 9; ++i) queue.push(kGreedy, "a");
  EXPECT_TRUE(queue.start());
  EXPECT_TRUE(queue.start());
  EXPECT_FALSE(queue.start()) << "half of them are one tenant's at most";
  queue.push(kModest, "B");
  EXPECT_EQ(queue.start(), "B");
  queue.push(kThird, "c");
  EXPECT_EQ(queue.start(), "c") << "the last one is for somebody who has none";
}

TEST(FairQueue, APlaceThatIsDoneServesTheNext) {
  FairQueue<Asker, std::string> queue(2);
  queue.push(kGreedy, "a");
  queue.push(kGreedy, "b");
  EXPECT_EQ(queue.start(), "a");
  EXPECT_FALSE(queue.start());
  queue.done(kGreedy);
  EXPECT_EQ(queue.start(), "b");
  EXPECT_FALSE(queue.start());
}

TEST(FairQueue, OneThatIsNotLimitedMayTakeEveryPlace) {
  FairQueue<Asker, int> queue(3, Asker{});
  for (int i = 0; i < 4; ++i) queue.push(std::nullopt, i);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(queue.start(), i);
  EXPECT_FALSE(queue.start());
}

TEST(FairQueue, WhatNobodyWaitsForIsNotStarted) {
  FairQueue<Asker, std::string> queue(4);
  queue.push(kGreedy, "gone");
  queue.push(kGreedy, "stays");
  queue.push(kModest, "gone");
  queue.drop([](const std::string& request) { return request == "gone"; });
  EXPECT_EQ(queue.start(), "stays");
  EXPECT_FALSE(queue.start());
}

}  // namespace
}  // namespace gnomon
