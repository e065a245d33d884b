// Nothing is allocated, and so nothing thrown, while a TakenApart is destroyed. Counts calls of operator new, so it is a
// program of its own.
#include "daemon/admin/taken_apart.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>
#include <optional>

namespace {
std::atomic<size_t> allocations = 0;
}

// Not inlined, as the compiler would warn of free() for memory that it takes to be of the usual operator new.
[[gnu::noinline]] void* operator new(size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, size_t) noexcept { std::free(memory); }

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
  const size_t before = allocations;
  taken.reset();
  EXPECT_EQ(allocations, before);
}

// What it is for: without it there is room made.
TEST(TakenApart, IsNeeded) {
  std::optional<json> whole(session());
  const size_t before = allocations;
  whole.reset();
  EXPECT_GT(allocations, before);
}

}  // namespace
}  // namespace gnomon::daemon
