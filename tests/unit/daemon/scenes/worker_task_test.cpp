// What a worker is given to do, as bytes.
#include "daemon/worker/task.h"

#include <gtest/gtest.h>

#include "tests/unit/scenes/support/written_bytes.h"

namespace gnomon::daemon {
namespace {

std::vector<std::byte> bytes_of(const WorkerTask& task) {
  return scenes::testing::written_bytes([&](std::FILE* file) { return write_task(task, file); });
}

TEST(WorkerTask, OfLoadingComesBackAsItWas) {
  using scenes::NodeMotion;
  WorkerTask task;
  task.max_memory_bytes = 6;
  task.max_cpu_seconds = 7;
  task.niceness = 8;
  task.work = scenes::LoadTask{.file = "folder/scene.glb",
                               .motions = {{"fan", NodeMotion::Kind::shift, {1, 2, 3}, std::chrono::seconds(4)}},
                               .limits = {.max_triangles = 5, .max_scene_bytes = 9}};
  const std::vector<std::byte> bytes = bytes_of(task);
  const auto back = read_task(bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->max_memory_bytes, 6u);
  EXPECT_EQ(back->max_cpu_seconds, 7u);
  EXPECT_EQ(back->niceness, 8);
  const auto& load = std::get<scenes::LoadTask>(back->work);
  EXPECT_EQ(load.file, "folder/scene.glb");
  EXPECT_EQ(load.motions, std::get<scenes::LoadTask>(task.work).motions);
  EXPECT_EQ(load.limits.max_triangles, 5u);
  EXPECT_EQ(load.limits.max_scene_bytes, 9u);
  for (size_t size = 0; size < bytes.size(); ++size) {
    ASSERT_FALSE(read_task(std::span(bytes).first(size))) << size << " of " << bytes.size();
  }
}

TEST(WorkerTask, OfBuildingComesBackAsItWas) {
  scenes::WorldMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  mesh.opaque_count = 1;
  gpu::BuildTask build;
  build.mesh = &mesh;
  build.budget_bytes = 3;
  WorkerTask task;
  task.work = build;
  const auto back = read_task(bytes_of(task));
  ASSERT_TRUE(back);
  const auto& read = std::get<gpu::BuildTask>(back->work);
  EXPECT_EQ(read.own_mesh.positions, mesh.positions);
  EXPECT_EQ(read.own_mesh.triangles, mesh.triangles);
  EXPECT_EQ(read.budget_bytes, 3u);
  mesh.triangles[0].z = 3;  // there is no such corner
  EXPECT_FALSE(read_task(bytes_of(task)));
}

}  // namespace
}  // namespace gnomon::daemon
