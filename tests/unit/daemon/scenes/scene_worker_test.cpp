// Scenes read by another process: the same scenes, and every end that such a process can come to.
#include "daemon/scenes/scene_worker.h"

#include <gtest/gtest.h>

#include <thread>

#include "tests/unit/scenes/support/gltf_file.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;
using namespace scenes::testing;

SceneWorkerOptions options() {
  return {.program = std::filesystem::path(GNOMON_BINARY_DIR) / "../libexec/gnomon/gnomon-scene-worker"};
}

Result<scenes::ScenePtr> read(const std::filesystem::path& file, const SceneWorkerOptions& how = options(),
                              std::stop_token stop = {}) {
  return load_in_worker(how, {"scene", file}, {}, stop);
}

// A program in the worker's place.
SceneWorkerOptions instead(const ScratchFolder& folder, const std::string& script) {
  SceneWorkerOptions how = options();
  how.program = folder.write("worker", "#!/bin/sh\n" + script + "\n");
  std::filesystem::permissions(how.program, std::filesystem::perms::owner_all);
  return how;
}

TEST(SceneWorker, ReadsWhatTheLoaderReads) {
  const ScratchFolder folder;
  const auto file = folder.write("scene.glb", triangle_file().glb());
  const auto here = scenes::load_scene(file);
  const auto there = read(file);
  ASSERT_TRUE(here);
  ASSERT_TRUE(there) << there.error().message;
  EXPECT_EQ((*there)->content_hash, (*here)->content_hash);
  EXPECT_EQ((*there)->name, (*here)->name);
  EXPECT_EQ((*there)->meshes[0].primitives[0].positions, (*here)->meshes[0].primitives[0].positions);
}

TEST(SceneWorker, HandsOnTheLoadersReason) {
  const ScratchFolder folder;
  const auto file = folder.write("scene.gltf", std::string("{}"));
  const auto here = scenes::load_scene(file);
  const auto there = read(file);
  ASSERT_FALSE(here);
  ASSERT_FALSE(there);
  EXPECT_EQ(there.error().message, here.error().message);
}

TEST(SceneWorker, AMissingProgramIsAReason) {
  SceneWorkerOptions how = options();
  how.program = "/nonexistent/gnomon-scene-worker";
  const auto scene = read("scene.glb", how);
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("cannot be started"), std::string::npos) << scene.error().message;
}

TEST(SceneWorker, ACrashCostsARefusal) {
  const ScratchFolder folder;
  const auto scene = read("scene.glb", instead(folder, "kill -SEGV $$"));
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().message, "its reader crashed (signal 11)");
}

TEST(SceneWorker, AnAnswerThatIsNoneIsARefusal) {
  const ScratchFolder folder;
  EXPECT_FALSE(read("scene.glb", instead(folder, "exit 0"))) << "the task is no answer";
  EXPECT_FALSE(read("scene.glb", instead(folder, ": >&3")));
  EXPECT_FALSE(read("scene.glb", instead(folder, "head -c 1000 /dev/urandom >&3")));
  EXPECT_FALSE(read("scene.glb", instead(folder, "exit 1")));
}

TEST(SceneWorker, IsStoppedAtItsDeadline) {
  const ScratchFolder folder;
  SceneWorkerOptions how = instead(folder, "exec sleep 1000");
  how.max_time = 0s;
  const auto scene = read("scene.glb", how);
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("takes more than"), std::string::npos) << scene.error().message;
}

TEST(SceneWorker, IsStoppedWhenNobodyWaits) {
  const ScratchFolder folder;
  std::stop_source stop;
  std::jthread leaving([&] { stop.request_stop(); });
  const auto scene = read("scene.glb", instead(folder, "exec sleep 1000"), stop.get_token());
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("nobody waits"), std::string::npos) << scene.error().message;
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // whose programs have no limit of memory
TEST(SceneWorker, MemoryBeyondItsLimitCostsARefusal) {
  const ScratchFolder folder;
  constexpr size_t kVertices = 6'000'000;  // within the loader's limits
  json root = json::parse(triangle_file().gltf());
  std::filesystem::resize_file(folder.write("zeros.bin", std::string()), kVertices * sizeof(glm::vec3));
  root["buffers"][0] = {{"uri", "zeros.bin"}, {"byteLength", kVertices * sizeof(glm::vec3)}};
  root["bufferViews"][0] = {{"buffer", 0}, {"byteLength", kVertices * sizeof(glm::vec3)}};
  root["accessors"][0]["count"] = kVertices;
  root["meshes"][0]["primitives"][0].erase("indices");
  const auto file = folder.write("bomb.gltf", root.dump());
  SceneWorkerOptions how = options();
  how.max_memory_bytes = uint64_t{160} << 20;
  const auto scene = read(file, how);
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("memory"), std::string::npos) << scene.error().message;
}
#endif

// The folder is all that it sees: a link that leads out of it is no way.
TEST(SceneWorker, ReadsNoFileOfAnotherFolder) {
  const ScratchFolder folder, elsewhere;
  elsewhere.write("secret.bin", std::vector<uint8_t>(36));
  std::filesystem::create_symlink(elsewhere.path() / "secret.bin", folder.path() / "linked.bin");
  GltfFile file = triangle_file();
  json root = json::parse(file.gltf());
  root["buffers"][0] = {{"uri", "linked.bin"}, {"byteLength", 36}};
  EXPECT_FALSE(read(folder.write("scene.gltf", root.dump())));
}

}  // namespace
}  // namespace gnomon::daemon
