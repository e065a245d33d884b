// Packs are made once for all who wait. What makes them is the test's; the devices never start.
#include "daemon/scenes/scene_packs.h"

#include <gtest/gtest.h>

#include <latch>
#include <semaphore>

namespace gnomon::daemon {
namespace {

constexpr TenantId kAsker{0}, kOtherAsker{1};

struct Packs {
  explicit Packs(ScenePacks::Make make) : packs(host, std::move(make)) {}

  static SceneForUse scene(uint32_t id) {
    SceneForUse use;
    use.id = SceneId{id};
    use.scene = std::make_shared<const scenes::Scene>();
    return use;
  }

  SceneCatalog catalog;
  Metrics metrics{{"default"}, {"a"}, "test", 1};
  Health health;
  DevicePool devices{1, 30.0, metrics, health};
  SceneLights lights{devices, {}, {}};
  SceneHost host{catalog, devices, lights, metrics, scenes::read_here};
  ScenePacks packs;
};

ScenePack pack_of(const std::string& sha256) {
  return {sha256, 3, std::make_shared<const std::vector<uint8_t>>(2)};
}

TEST(ScenePacks, AreMadeOnceForAllWhoWait) {
  std::binary_semaphore go{0};
  std::atomic<int> made = 0;
  Packs to([&](const scenes::Scene&) -> Result<ScenePack> {
    go.acquire();
    ++made;
    return pack_of("ab");
  });
  std::latch answered(3);
  for (int i = 0; i < 3; ++i) {
    to.packs.get("a", Packs::scene(1), kAsker, [&](const Result<ScenePackPtr>& pack) {
      EXPECT_TRUE(pack && (*pack)->sha256 == "ab");
      answered.count_down();
    });
  }
  go.release();
  answered.wait();
  EXPECT_EQ(made, 1);
}

TEST(ScenePacks, OneThatIsKeptWithItsSceneIsNotMadeAgain) {
  Packs to([](const scenes::Scene&) -> Result<ScenePack> { return Error{"made again"}; });
  SceneForUse scene = Packs::scene(1);
  scene.pack = std::make_shared<const ScenePack>(pack_of("cd"));
  bool there = false;
  to.packs.get("a", std::move(scene), kAsker,
               [&](const Result<ScenePackPtr>& pack) { there = pack && (*pack)->sha256 == "cd"; });
  EXPECT_TRUE(there);
}

TEST(ScenePacks, WhatCannotBeMadeIsSaidAndTriedAgain) {
  int tries = 0;
  Packs to([&](const scenes::Scene&) -> Result<ScenePack> {
    if (++tries == 2) throw std::bad_alloc();
    return Error{"no pack"};
  });
  for (const char* why : {"no pack", "no memory", "no pack"}) {
    std::binary_semaphore answered{0};
    to.packs.get("a", Packs::scene(1), kAsker, [&](const Result<ScenePackPtr>& pack) {
      ASSERT_FALSE(pack);
      EXPECT_EQ(pack.error().message, why);
      answered.release();
    });
    answered.acquire();
  }
}

// Makes packs that are done when the test says so.
struct SlowPacks {
  ScenePacks::Make make() {
    return [this](const scenes::Scene&) -> Result<ScenePack> {
      begun.release();
      go.acquire();
      return pack_of("ab");
    };
  }
  std::counting_semaphore<8> begun{0}, go{0};
};

TEST(ScenePacks, ATenantsPackWaitsForNoneOfAnother) {
  SlowPacks slow;
  Packs to(slow.make());
  std::latch answered(3);
  const auto ready = [&](const Result<ScenePackPtr>&) { answered.count_down(); };
  to.packs.get("a", Packs::scene(1), kAsker, ready);
  to.packs.get("b", Packs::scene(2), kAsker, ready);
  slow.begun.acquire();
  to.packs.get("c", Packs::scene(3), kOtherAsker, ready);
  slow.begun.acquire();
  EXPECT_FALSE(slow.begun.try_acquire()) << "one at a time of a tenant";
  slow.go.release(3);
  answered.wait();
}

TEST(ScenePacks, APackThatTwoWaitForIsInTheQueuesOfBoth) {
  SlowPacks slow;
  Packs to(slow.make());
  std::latch answered(3);
  const auto ready = [&](const Result<ScenePackPtr>&) { answered.count_down(); };
  to.packs.get("a", Packs::scene(1), kAsker, ready);
  slow.begun.acquire();
  to.packs.get("b", Packs::scene(2), kAsker, ready);
  to.packs.get("b", Packs::scene(2), kOtherAsker, ready);
  slow.begun.acquire();  // beside the first one's
  slow.go.release(2);
  answered.wait();
  EXPECT_FALSE(slow.begun.try_acquire()) << "it is made once";
}

TEST(ScenePacks, WhatNobodyWaitsForIsNotBegun) {
  SlowPacks slow;
  Packs to(slow.make());
  std::latch answered(2);
  const auto ready = [&](const Result<ScenePackPtr>&) { answered.count_down(); };
  const auto never = [](const Result<ScenePackPtr>&) { FAIL() << "it was given up"; };
  to.packs.get("a", Packs::scene(1), kAsker, ready);
  slow.begun.acquire();
  const auto gone = to.packs.get("b", Packs::scene(2), kAsker, never);
  const auto shared = to.packs.get("c", Packs::scene(3), kAsker, never);
  to.packs.get("c", Packs::scene(3), kAsker, ready);
  to.packs.give_up(gone);
  to.packs.give_up(shared);
  slow.go.release(2);
  slow.begun.acquire();
  answered.wait();
  EXPECT_FALSE(slow.begun.try_acquire()) << "only what somebody waits for still";
}

}  // namespace
}  // namespace gnomon::daemon
