#include "daemon/scenes/load_queue.h"

#include <gtest/gtest.h>

#include <string>

namespace gnomon::daemon {
namespace {

TEST(LoadQueue, TenantsTakeTurnsHoweverManyOneAsksFor) {
  LoadQueue<std::string> queue;
  const TenantId greedy{0}, modest{1};
  for (const char* scene : {"a", "b", "c"}) queue.push(greedy, scene);
  queue.push(modest, "d");
  queue.push(std::nullopt, "e");
  std::string order;
  while (!queue.empty()) order += queue.pop();
  EXPECT_EQ(order.find('d'), 1u) << order << ": after the one that was first";
  EXPECT_LE(order.find('e'), 2u) << order;
  EXPECT_LT(order.find('a'), order.find('b'));
  EXPECT_LT(order.find('b'), order.find('c'));
}

TEST(LoadQueue, WhoComesLaterWaitsForNoQueueOfAnother) {
  LoadQueue<int> queue;
  for (int i = 0; i < 100; ++i) queue.push(TenantId{3}, i);
  EXPECT_EQ(queue.pop(), 0);
  queue.push(TenantId{1}, -1);
  EXPECT_EQ(queue.pop(), -1);
  EXPECT_EQ(queue.pop(), 1);
}

}  // namespace
}  // namespace gnomon::daemon
