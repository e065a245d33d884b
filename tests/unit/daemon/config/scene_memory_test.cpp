#include "daemon/config/scene_memory.h"

#include <gtest/gtest.h>

#include "daemon/config/machine_memory.h"

namespace gnomon::daemon {
namespace {

constexpr uint64_t kMebi = 1 << 20;

TEST(SceneMemory, IsWhatTheConfigurationSaysOrHalfOfTheMachines) {
  Config config;
  EXPECT_EQ(scene_memory_bytes(config), usable_memory_bytes() / 2);
  config.scenes.max_memory_mb = 3200;
  EXPECT_EQ(scene_memory_bytes(config), 3200 * kMebi);
}

TEST(SceneMemory, LeavesRoomForOtherScenesAndForThoseOfEachTenant) {
  Config config;
  config.scenes.max_memory_mb = 3200;
  EXPECT_EQ(most_light_buffer_room(config), 200 * kMebi);
  config.tenants.resize(2);
  EXPECT_EQ(most_light_buffer_room(config), 200 * kMebi);
  config.tenants[1].max_scene_memory_mb = 400;
  EXPECT_EQ(most_light_buffer_room(config), 100 * kMebi);
}

}  // namespace
}  // namespace gnomon::daemon
