#include "daemon/scenes/scene_account.h"

#include <gtest/gtest.h>

#include <set>

namespace gnomon::daemon {
namespace {

constexpr uint64_t kMiB = uint64_t{1} << 20;
const TenantId kOne{0}, kOther{1};
using Names = std::vector<std::string>;

class SceneAccounts : public testing::Test {
 protected:
  SceneAccounts() { account_.set_limits({.all_bytes = 100 * kMiB, .of_tenant = {60 * kMiB, 0}}); }

  Names leaving(SceneAsker asker, uint64_t mib) const {
    const auto room =
        account_.make_room(asker, mib * kMiB, [&](const std::string& n) { return !in_use_.contains(n); });
    return room ? *room : Names{room.error().message};
  }

  SceneAccount account_;
  std::set<std::string> in_use_;
};

TEST_F(SceneAccounts, WhatFitsMovesNobody) {
  account_.add("a", kOne, 30 * kMiB);
  EXPECT_EQ(leaving(kOther, 50), Names{});
  EXPECT_EQ(account_.bytes(), 30 * kMiB);
}

TEST_F(SceneAccounts, TheLeastRecentlyUsedLeavesFirst) {
  account_.add("a", kOne, 20 * kMiB);
  account_.add("b", kOther, 20 * kMiB);
  account_.add("c", kOther, 20 * kMiB);
  account_.used("a");
  account_.used("b");
  EXPECT_EQ(leaving(kOne, 40), Names{}) << "it fits";
  account_.add("d", kOther, 10 * kMiB);
  EXPECT_EQ(leaving(kOne, 40), Names{"c"});
}

TEST_F(SceneAccounts, WhatIsUsedStays) {
  account_.add("a", kOther, 50 * kMiB);
  account_.add("b", kOther, 40 * kMiB);
  in_use_ = {"a"};
  EXPECT_EQ(leaving(kOne, 45), Names{"b"});
  EXPECT_EQ(leaving(kOne, 55), Names{"it needs 56 MiB of memory, and a scene may have 50 MiB now"});
}

TEST_F(SceneAccounts, TheOperatorsScenesCountAndStay) {
  account_.add("a", std::nullopt, 70 * kMiB);
  EXPECT_EQ(leaving(kOne, 40), Names{"it needs 41 MiB of memory, and a scene may have 30 MiB now"});
  EXPECT_EQ(leaving(kOne, 30), Names{});
}

TEST_F(SceneAccounts, ATenantsOwnLimitMovesItsOwnScenes) {
  account_.add("theirs", kOther, 10 * kMiB);
  account_.add("first", kOne, 30 * kMiB);
  account_.add("second", kOne, 20 * kMiB);
  EXPECT_EQ(leaving(kOne, 20), Names{"first"});
  EXPECT_EQ(leaving(kOne, 61), Names{"it needs 62 MiB of memory, and a scene may have 60 MiB now"});
}

TEST_F(SceneAccounts, ATenantWithoutALimitMayHaveHalf) {
  EXPECT_EQ(leaving(kOther, 50), Names{});
  EXPECT_EQ(leaving(kOther, 51), Names{"it needs 52 MiB of memory, and a scene may have 50 MiB now"});
}

TEST_F(SceneAccounts, WithoutALimitEverythingFits) {
  account_.set_limits({});
  account_.add("a", kOne, 1000 * kMiB);
  EXPECT_EQ(leaving(kOne, 100'000), Names{});
}

}  // namespace
}  // namespace gnomon::daemon
