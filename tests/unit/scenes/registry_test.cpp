#include "scenes/registry.h"

#include <gtest/gtest.h>

#include <thread>

#include "tests/unit/scenes/support/gltf_file.h"

namespace gnomon::scenes::testing {
namespace {

TEST(Registry, LoadsOnceHoweverManyAsk) {
  const ScratchFolder folder;
  const auto file = folder.write("scene.gltf", triangle_file().gltf());
  Registry registry({{"one", file}, {"two", file}}, {});
  EXPECT_TRUE(registry.loaded().empty());

  std::vector<ScenePtr> seen(8);
  {
    std::vector<std::jthread> threads;
    for (ScenePtr& mine : seen) {
      threads.emplace_back([&] {
        Result<LoadedScene> loaded = registry.get("one");
        if (loaded) mine = loaded->scene;
      });
    }
  }
  ASSERT_NE(seen[0], nullptr);
  for (const ScenePtr& scene : seen) EXPECT_EQ(scene, seen[0]);

  ASSERT_EQ(registry.loaded().size(), 1u);
  const LoadedScene loaded = registry.loaded()[0];
  EXPECT_EQ(loaded.id, SceneId{0});
  EXPECT_EQ(loaded.memory_bytes, seen[0]->memory_bytes());
  EXPECT_GT(loaded.load_seconds, 0.0);
  ASSERT_TRUE(registry.get("two"));
  EXPECT_EQ(registry.get("two")->id, SceneId{1});
  EXPECT_NE(registry.get("two")->scene, seen[0]);
}

TEST(Registry, KnowsItsNames) {
  Registry registry({{"b", "b.glb"}, {"a", "a.glb"}}, {});
  EXPECT_TRUE(registry.knows("a"));
  EXPECT_FALSE(registry.knows("c"));
  EXPECT_EQ(registry.names(), (std::vector<std::string>{"a", "b"}));
  const Result<LoadedScene> unknown = registry.get("c");
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message.find("'c'"), std::string::npos);
}

TEST(Registry, ARefusalIsRememberedWhileTheFileStaysTheSame) {
  const ScratchFolder folder;
  const auto file = folder.write("slow.gltf", std::string("{}"));
  int reads = 0;
  Registry registry({{"slow", file}}, {},
                    [&](const SceneSource&, const LoadLimits&, const Watch&) -> Result<ScenePtr> {
                      ++reads;
                      return Error{"it is a bomb"};
                    });
  for (int i = 0; i < 3; ++i) EXPECT_EQ(registry.get("slow").error().message, "it is a bomb");
  EXPECT_EQ(reads, 1);
  registry.retry("slow");
  EXPECT_FALSE(registry.get("slow"));
  EXPECT_EQ(reads, 2) << "an operator may insist";
  std::filesystem::last_write_time(file, std::filesystem::last_write_time(file) + std::chrono::seconds(1));
  EXPECT_FALSE(registry.get("slow"));
  EXPECT_EQ(reads, 3) << "the file is another one";
}

TEST(Registry, AFailureIsTriedAgain) {
  const ScratchFolder folder;
  const auto file = folder.path() / "late.gltf";
  Registry registry({{"late", file}}, {});
  ASSERT_FALSE(registry.get("late"));
  folder.write("late.gltf", triangle_file().gltf());
  EXPECT_TRUE(registry.get("late"));
}

}  // namespace
}  // namespace gnomon::scenes::testing
