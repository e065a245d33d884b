// Nothing is allocated, and so nothing thrown, while a TakenApart is destroyed. Counts calls of operator new, so it is a
// program of its own.
#include "daemon/admin/taken_apart.h"

#include <gtest/gtest.h>

#include <optional>

#include "tests/tools/allocations/allocations.h"

namespace gnomon::daemon {
namespace {

using nlohmann::json;

json session() {
  json lists = json::array();
  for (int i = 0; i < 100; ++i)
    lists.push_back({{"served", {{"width", i}, {"name", "of more than fifteen letters"}}}});
  return {{"id", "1"}, {"lists", lists}, {"none", nullptr}, {"empty", json::object()}};
}

TEST(TakenApart, AllocatesNothing) {
  std::optional<TakenApart> taken(session());
  ASSERT_EQ(taken->value().size(), 4u);
  const uint64_t before = test::allocations();
  taken.reset();
  EXPECT_EQ(test::allocations(), before);
}

// What it is for: without it there is room made.
TEST(TakenApart, IsNeeded) {
  std::optional<json> whole(session());
  const uint64_t before = test::allocations();
  whole.reset();
  EXPECT_GT(test::allocations(), before);
}

}  // namespace
}  // namespace gnomon::daemon
